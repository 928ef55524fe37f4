#pragma once

#include <string>
#include <vector>

#include "lode/core/result.h"

namespace lode::bench {

/// What the benchmark finds, as Markdown for people and CSV for the plots. A cell is text without
/// commas; whole numbers are given bare and grouped by thousands in Markdown.
struct Table {
  struct Column {
    std::string name;     ///< In CSV.
    std::string heading;  ///< In Markdown.
  };
  std::string name;  ///< Of its files.
  std::string title;
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;
};

[[nodiscard]] std::string to_markdown(const Table& table);
[[nodiscard]] std::string to_csv(const Table& table);

/// Prints the table, and writes DIRECTORY/NAME.md and .csv unless `directory` is empty.
[[nodiscard]] Result<void> publish(const Table& table, const std::string& directory);

}  // namespace lode::bench
