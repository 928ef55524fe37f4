#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "query_options.h"
#include "tetra_input.h"

namespace lode::cli {

// What `extract` and `render` ask of a mesh of cells alike.

/// The query but for what a transfer function shows and what needs the field: see set_shares() and
/// wanted_regions(). Reads the view's camera. `answer`: what asks for it, in messages; `own_view`:
/// the view where the arguments name none.
[[nodiscard]] Result<TetraMeshOptions> to_tetra_query(const QueryArguments& arguments,
                                                      const ExtractionArguments& extraction,
                                                      const char* answer,
                                                      const std::optional<View>& own_view = {});

/// Of tolerances that are shares of the range of values.
void set_shares(const ExtractionArguments& extraction, const QueryArguments& arguments,
                const TetraFieldInfo& field, Query& query);
/// Of a share as typed the tolerance in a field; of a field of one value any.
void set_field_share(const std::string& text, const TetraFieldInfo& field,
                     std::optional<double>& tolerance);

/// An error of the library that begins with what it calls an option.
[[nodiscard]] Error naming_option(const char* option, const std::string& path, const Error& error);

/// Numbers of --region's. `path`: of the mesh, for messages.
[[nodiscard]] Result<std::vector<std::int64_t>> wanted_regions(const std::string& path,
                                                               const TetraInfo& info,
                                                               const QueryArguments& arguments);

/// The files that the arguments name: a camera, a transfer function.
[[nodiscard]] std::vector<std::string> files_of(const QueryArguments& arguments);

/// Where the coarsest mesh has more cells than --max-cells, else empty. `Report`: of a mesh or a
/// surface.
template <typename Report>
std::string budget_warning(const Report& report) {
  if (report.budget_met) return {};
  return fmt::format("--max-cells is not met: the coarsest mesh has {} simplices",
                     report.n_cut_cells);
}
template <typename Report>
void warn_of_budget(Session& session, const Report& report) {
  if (const std::string message = budget_warning(report); !message.empty()) session.warn(message);
}
/// Of refinement that a deadline ended.
void add_deadline(bool is_settled, Table& table);

/// Of a foreign file that is built what its query needs is read and found, too.
[[nodiscard]] ReadingArguments reading_for(const ReadingArguments& reading,
                                           const QueryArguments& arguments);

/// Fails, naming the file, where space errors are asked for and it has none of the field.
[[nodiscard]] Result<void> check_space_errors(const std::string& path, const TetraFieldInfo& field,
                                              const QueryArguments& arguments);

/// Achieved, where they were asked for.
struct SpaceErrors {
  std::optional<double> world{};
  std::optional<double> pixels{};
};
void add_space_error(const QueryArguments& arguments, const SpaceErrors& achieved, Table& table,
                     Json& json);
/// A tolerance in field units, which there may be none of.
[[nodiscard]] std::string describe_max_error(double max_error);
[[nodiscard]] Json max_error_json(double max_error);

}  // namespace lode::cli
