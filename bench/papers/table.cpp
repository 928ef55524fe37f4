#include "bench/papers/table.h"

#include <algorithm>
#include <cstdio>

#include "lode/core/atomic_file.h"

namespace lode::bench {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string grouped(const std::string& cell) {
  if (cell.empty() || !std::ranges::all_of(cell, is_digit)) return cell;
  std::string result = cell;
  for (std::size_t at = cell.size(); at > 3; at -= 3) result.insert(at - 3, ",");
  return result;
}

/// `cell_of` of every element, with `separator` between them.
template <typename Row, typename CellOf>
std::string joined(const Row& row, const std::string& separator, const CellOf& cell_of) {
  std::string result;
  for (const auto& element : row) {
    if (!result.empty()) result += separator;
    result += cell_of(element);
  }
  return result;
}

Result<void> write_file(const std::string& path, const std::string& text) {
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  LODE_CHECK(file.write(text));
  return file.commit();
}

}  // namespace

std::string to_markdown(const Table& table) {
  const auto line = [](const auto& row, const auto& cell_of) {
    return "| " + joined(row, " | ", cell_of) + " |\n";
  };
  std::string result =
      line(table.columns, [](const Table::Column& column) { return column.heading; });
  result += "|";
  for (std::size_t i = 0; i < table.columns.size(); ++i) result += "---|";
  result += "\n";
  for (const auto& row : table.rows) result += line(row, grouped);
  return result;
}

std::string to_csv(const Table& table) {
  std::string result =
      joined(table.columns, ",", [](const Table::Column& column) { return column.name; }) + "\n";
  for (const auto& row : table.rows)
    result += joined(row, ",", [](const std::string& cell) { return cell; }) + "\n";
  return result;
}

Result<void> publish(const Table& table, const std::string& directory) {
  fmt::print("{}\n\n{}\n", table.title, to_markdown(table));
  std::fflush(stdout);
  if (directory.empty()) return {};
  LODE_CHECK(write_file(directory + "/" + table.name + ".md", to_markdown(table)));
  return write_file(directory + "/" + table.name + ".csv", to_csv(table));
}

}  // namespace lode::bench
