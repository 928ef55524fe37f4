#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "command.h"
#include "text.h"

namespace lode::cli {

/// The options of distances, with and without simplification, as typed.
struct SimplifyArguments {
  bool simplifies = false;
  bool removes_slivers = false;
  std::string max_distance;

  [[nodiscard]] bool is_wanted() const { return simplifies || removes_slivers; }
  /// Of the option that is wanted.
  [[nodiscard]] const char* name() const {
    return simplifies || !removes_slivers ? "--simplify" : "--remove-slivers";
  }
};

void add_simplify_options(CLI::App& app, SimplifyArguments& arguments);

/// Refuses a share of a range that is none.
[[nodiscard]] Result<void> check_simplify_range(const ExtractOptions& options, double range_min,
                                                double range_max);

/// Checks them against the others, and sets the distance: max_distance, or simplify_distance. What
/// is simplified is of full resolution unless a max_error is set.
[[nodiscard]] Result<void> apply_simplify_options(const SimplifyArguments& arguments,
                                                  ExtractOptions& options);

/// For a file's comment: ", simplified within ...", or nothing.
[[nodiscard]] std::string simplify_comment(const ExtractReport& report);

/// For a file's comment: ", max_distance ...", or nothing.
[[nodiscard]] std::string distance_comment(const ExtractReport& report);

/// The keys and lines of how a distance without simplification was kept; none where none was asked.
void add_distance(Json& json, const ExtractReport& report);
void add_distance(Table& table, const ExtractReport& report);

/// The keys and lines of what simplification did; none where there was none.
void add_simplified(Json& json, const ExtractReport& report);
void add_simplified(Table& table, const ExtractReport& report);

}  // namespace lode::cli
