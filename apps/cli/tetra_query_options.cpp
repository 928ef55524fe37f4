#include "tetra_query_options.h"

#include <cmath>

#include "lode/api/mesh_picture.h"
#include "tolerance.h"
#include "warp_options.h"

namespace lode::cli {

Result<TetraMeshOptions> to_tetra_query(const QueryArguments& arguments,
                                        const ExtractionArguments& extraction, const char* answer,
                                        const std::optional<View>& own_view) {
  LODE_CHECK(check_view_size(arguments));
  LODE_TRY(const QueryArguments plain, without_share(arguments));
  TetraMeshOptions options;
  LODE_TRY(options.query, to_query(plain, extraction, answer));
  options.query.view = own_view;
  if (!arguments.view.empty()) {
    LODE_TRY(options.query.view, read_view(arguments));
  }
  LODE_CHECK(add_space_tolerances(arguments, options.query));
  LODE_TRY(options.deadline_s, to_deadline(arguments));
  LODE_TRY(options.threshold, to_threshold(arguments));
  options.patches = arguments.patches;
  return options;
}

void set_shares(const ExtractionArguments& extraction, const QueryArguments& arguments,
                const TetraFieldInfo& field, Query& query) {
  set_field_share(extraction.max_error, field, query.max_error);
  set_field_share(arguments.max_error_outside, field, query.max_error_outside);
}

void set_field_share(const std::string& text, const TetraFieldInfo& field,
                     std::optional<double>& tolerance) {
  set_share(text, field.range_min, field.range_max, tolerance);
  // Of one value: any mesh has no error, and 0 would ask for the finest.
  if (is_share(text) && field.range_min == field.range_max)
    tolerance = std::numeric_limits<double>::infinity();
}

Error naming_option(const char* option, const std::string& path, const Error& error) {
  const std::size_t colon = error.message.find(": ");
  const std::string rest = colon == std::string::npos ? error.message : error.message.substr(colon);
  return fail("{}{}, of {}", option, rest, path);
}

Result<std::vector<std::int64_t>> wanted_regions(const std::string& path, const TetraInfo& info,
                                                 const QueryArguments& arguments) {
  auto regions = find_regions(info, arguments.regions);
  if (!regions) return naming_option("--region", path, regions.error());
  return regions;
}

std::vector<std::string> files_of(const QueryArguments& arguments) {
  std::vector<std::string> files;
  if (!arguments.view.empty()) files.push_back(arguments.view);
  if (!arguments.opacity.empty() && !is_transfer_preset(arguments.opacity))
    files.push_back(arguments.opacity);
  return files;
}

ReadingArguments reading_for(const ReadingArguments& reading, const QueryArguments& arguments) {
  ReadingArguments made = with_warp(reading, arguments.warp);
  made.has_space_errors = !arguments.max_space_error.empty() || !arguments.max_error_px.empty();
  return made;
}

Result<void> check_space_errors(const std::string& path, const TetraFieldInfo& field,
                                const QueryArguments& arguments) {
  const bool is_asked = !arguments.max_space_error.empty() || !arguments.max_error_px.empty();
  if (!is_asked || field.base_world_error) return {};
  return fail(
      "{}: expected a model of build --space-errors with {}, got one without space errors of {}",
      path, arguments.max_space_error.empty() ? "--max-error-px" : "--max-space-error", field.name);
}

void add_space_error(const QueryArguments& arguments, const SpaceErrors& achieved, Table& table,
                     Json& json) {
  if (achieved.world) {
    json["achieved_space_error"] = *achieved.world;
    table.add(
        {"space error", fmt::format("{}{}, by an estimate{}", format_number(*achieved.world),
                                    arguments.max_space_error.empty()
                                        ? ""
                                        : fmt::format(" of up to {}", arguments.max_space_error),
                                    arguments.opacity.empty() ? "" : kWhereShown)});
  }
  if (achieved.pixels) {
    json["achieved_px"] = *achieved.pixels;
    table.add({"pixels",
               fmt::format("{} of up to {}, by an estimate{}", format_number(*achieved.pixels),
                           arguments.max_error_px, arguments.opacity.empty() ? "" : kWhereShown)});
  }
}

std::string describe_max_error(double max_error) {
  return std::isfinite(max_error) ? format_number(max_error) : "any";
}
Json max_error_json(double max_error) {
  return std::isfinite(max_error) ? Json(max_error) : Json(nullptr);
}

void add_deadline(bool is_settled, Table& table) {
  if (!is_settled) table.add({"deadline", "reached: as accurate as it allows"});
}

}  // namespace lode::cli
