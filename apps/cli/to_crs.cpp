#include "to_crs.h"

#include <algorithm>

namespace lode::cli {

void add_to_crs(CLI::App& app, TerrainArguments& arguments, const char* help) {
  app.add_option("--to-crs", arguments.to_crs, help)->type_name("EPSG:N|WKT")->group("Heights");
}

Result<void> check_to_crs(const TerrainArguments& arguments) {
  if (arguments.to_crs.empty()) return {};
  const Result<void> status = check_target_crs(arguments.to_crs);
  return status ? status : fail("--to-crs: {}", status.error().message);
}

Result<void> check_to_crs_output(const TerrainArguments& arguments, const std::string& output) {
  if (arguments.to_crs.empty()) return {};
  if (arguments.wrap)
    return fail(
        "--wrap: expected no --to-crs with it: the seam at which a raster is closed is one of "
        "longitudes, and lies elsewhere, or nowhere, in another CRS");
  if (!is_geojson_path(output)) return {};
  return fail(
      "--to-crs: expected an output that ends in .gpkg or .vtp, got {}: GeoJSON is in longitudes "
      "and latitudes of WGS 84 (RFC 7946), with or without it",
      output);
}

Result<std::optional<TargetCrs>> open_to_crs(const std::string& path,
                                             const TerrainArguments& arguments,
                                             const HeightFrame& frame, Session& session) {
  if (arguments.to_crs.empty()) return std::optional<TargetCrs>();
  const Place middle = frame.world((frame.n_columns - 1) / 2.0, (frame.n_rows - 1) / 2.0);
  auto target = open_target_crs(frame.crs, arguments.to_crs, middle);
  if (!target) return fail("{}: --to-crs: {}", path, target.error().message);
  if (target->is_guess)
    session.warn(fmt::format(
        "{}: --to-crs: PROJ knows no way between the datums of its CRS and of {}, with the grids "
        "that are there, and takes one for the other: places may be off by hundreds of metres",
        path, target->name));
  return std::optional(*std::move(target));
}

Result<SourceCrs> open_from_crs(const std::string& path, const TerrainArguments& arguments,
                                const HeightFrame& frame) {
  const Place middle = frame.world((frame.n_columns - 1) / 2.0, (frame.n_rows - 1) / 2.0);
  auto source = open_source_crs(arguments.to_crs, frame.crs, middle);
  if (!source) return fail("{}: --to-crs: {}", path, source.error().message);
  return *std::move(source);
}

Json mapped_json(const std::optional<MappedAnswer>& mapped,
                 const std::optional<double>& tolerance) {
  if (!mapped) return nullptr;
  const MappedErrors& errors = mapped->errors;
  const bool has_all = mapped->measured_at == MeasuredAt::samples;
  return {{"name", mapped->target.name},
          {"crs", mapped->target.crs},
          {"measured_at", has_all ? "all samples" : "vertices of the finest mesh"},
          {"samples", errors.n_samples},
          {"samples_in_no_triangle", errors.n_without},
          {"error", errors.error},
          {"error_met", has_all && tolerance ? Json(errors.error <= *tolerance) : Json(nullptr)},
          {"worst", {errors.worst[0], errors.worst[1]}},
          {"seconds", mapped->seconds}};
}

void add_mapped_rows(const MappedAnswer& mapped, Table& table) {
  const MappedErrors& errors = mapped.errors;
  const bool has_all = mapped.measured_at == MeasuredAt::samples;
  table.add({"written in", mapped.target.name});
  table.add(
      {"error there", fmt::format("{} at {} {}, measured", format_number(errors.error),
                                  format_count(errors.n_samples),
                                  has_all ? "samples" : "vertices of the file's finest mesh")});
  if (errors.n_without > 0)
    table.add({"in no triangle there",
               fmt::format("{} {}", format_count(errors.n_without),
                           has_all ? "samples, beside edges that bend" : "of those vertices")});
  table.add({"transform, measure", format_seconds(mapped.seconds)});
}

void warn_of_mapped(const MappedAnswer& mapped, const TerrainReport& report, Session& session) {
  if (mapped.measured_at == MeasuredAt::kept_vertices) {
    session.warn(fmt::format(
        "--to-crs: the error holds in the CRS of the file only, as its samples are not at hand: in "
        "{} it is measured at vertices of the file's finest mesh, and samples between them may err "
        "by more; the raster or points in the file's place have all",
        mapped.target.name));
    return;
  }
  const double within = std::max(report.max_error, report.achieved_error);
  if (!report.is_uniform || mapped.errors.error <= within) return;
  session.warn(fmt::format(
      "--to-crs: in {} samples are up to {} from the surface, as they lie elsewhere in its "
      "triangles than in the CRS of the file, where they are within {}",
      mapped.target.name, format_number(mapped.errors.error), format_number(within)));
}

const std::string& written_crs(const OpenedTerrain& opened,
                               const std::optional<TargetCrs>& target) {
  return target ? target->crs : opened.facts.frame.crs;
}

Result<void> map_to_crs(const std::string& path, const std::optional<TargetCrs>& target,
                        std::vector<std::span<Place>>& lines, Session& session, Json& json,
                        Table& table) {
  json["to_crs"] = nullptr;
  if (!target) return {};
  LODE_TRY(const double bend,
           naming(path, map_lines(lines, *target->map, target->name, session.progress()), session));
  json["to_crs"] = {{"name", target->name}, {"crs", target->crs}, {"largest_bend", bend}};
  const std::string& unit = target->metric.ellipsoid ? "" : target->metric.unit;
  table.add({"written in",
             fmt::format("{}; straight pieces would bend by up to {}{}{} there", target->name,
                         format_number(bend), unit.empty() ? "" : " ", unit)});
  return {};
}

HeightFrame frame_round(const TerrainSurface& terrain, const HeightFrame& own,
                        const std::string& crs) {
  const auto x = [](const Vec3d& p) { return p[0]; };
  const auto y = [](const Vec3d& p) { return p[1]; };
  const auto [west, east] = std::ranges::minmax(terrain.places, {}, x);
  const auto [south, north] = std::ranges::minmax(terrain.places, {}, y);
  HeightFrame frame;
  frame.n_columns = frame.n_rows = 2;
  frame.to_world = {west[0], east[0] - west[0], 0, south[1], 0, north[1] - south[1]};
  frame.crs = crs;
  frame.vertical_unit = own.vertical_unit;
  return frame;
}

}  // namespace lode::cli
