#include "terrain_raster_options.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "outputs.h"
#include "parse.h"
#include "terrain_arguments.h"

namespace lode::cli {
namespace {

const char* json_name_of(RasterErrorKind kind) {
  if (kind == RasterErrorKind::measured) return "measured at samples";
  return kind == RasterErrorKind::bound ? "bound at samples" : "of the TIN at points";
}

std::string describe_error(const TerrainRasterReport& report) {
  const std::string error = format_number(report.error);
  if (report.error_kind == RasterErrorKind::measured)
    return fmt::format("{} of {} samples at most, as written", error,
                       format_count(report.n_heights));
  if (report.error_kind == RasterErrorKind::bound)
    return fmt::format("at most {} at samples, as written", error);
  return fmt::format("{} of the TIN at what it was made of; pixels are elsewhere", error);
}

}  // namespace

void add_raster_options(CLI::App& app, RasterArguments& arguments) {
  const char* group = "Rasters to write (.tif)";
  app.add_option("--cell", arguments.cell,
                 "Width and height of pixels in units of the CRS; needed with points (default: the "
                 "grid of the raster that is read)")
      ->type_name("SIZE")
      ->group(group);
  app.add_option("--difference", arguments.difference,
                 "Also write what is written less the raster that it is of, at every sample")
      ->type_name("DIFF.tif")
      ->group(group);
  app.add_option("--against", arguments.against,
                 "With --difference, of a .lode file of a model that has not all heights itself: "
                 "the raster that it was built of, read as it is, without --band, --variable, "
                 "--encoding, --wrap or another CRS of heights")
      ->type_name("DEM")
      ->group(group);
}

Result<void> check_no_raster(const RasterArguments& arguments, const std::string& path) {
  if (arguments.is_empty()) return {};
  return fail("{}: expected {} with --cell, --difference or --against, got another file", path,
              kTerrainFiles);
}

Result<void> check_raster_arguments(const RasterArguments& arguments, const std::string& input,
                                    const std::string& output) {
  if (!is_geotiff_path(output)) {
    if (arguments.is_empty()) return {};
    return fail("{}: expected an output that ends in .tif with {}, got another", output,
                arguments.cell.empty() ? "--difference" : "--cell");
  }
  if (!arguments.against.empty() && (arguments.difference.empty() || !is_lode_path(input)))
    return fail("--against: expected --difference with it, of a .lode file, got {}",
                arguments.difference.empty() ? "none" : input);
  if (!arguments.against.empty() && !is_height_path(arguments.against))
    return fail(
        "--against: expected a raster of heights (.tif, .asc, .hgt, .nc, .png, ...), got '{}'",
        arguments.against);
  LODE_TRY(const TerrainRasterOptions options, to_raster_options(arguments));
  if (is_point_path(input) && !options.cell)
    return fail("{}: expected --cell, the size of pixels, for a raster of points, got none", input);
  if (options.difference.empty()) return {};
  if (!is_geotiff_path(options.difference))
    return fail("--difference: expected a file that ends in .tif, got '{}'", options.difference);
  if (options.cell || is_point_path(input))
    return fail("--difference: expected a raster on its own grid, without --cell, got {}", input);
  return {};
}

Result<void> check_terrain_surface(const std::string& path) {
  auto status = check_surface_extension(path);
  if (status) return {};
  return fail("{}; or of terrain in .tif", status.error().message);
}

Result<TerrainRasterOptions> to_raster_options(const RasterArguments& arguments) {
  TerrainRasterOptions options{.difference = arguments.difference};
  if (arguments.cell.empty()) return options;
  LODE_TRY(options.cell, parse_number("--cell", arguments.cell));
  if (!(*options.cell > 0)) return fail("--cell: expected a number > 0, got '{}'", arguments.cell);
  return options;
}

Result<void> read_samples(const RasterArguments& arguments, const OpenedTerrain& opened,
                          TerrainRasterOptions& wanted, Session& session) {
  const std::string& path = arguments.against;
  if (path.empty()) return {};
  if (opened.samples) {
    session.warn(fmt::format("--against: {} is not read: the file has all heights", path));
    return {};
  }
  LODE_TRY(HeightRaster read, read_heights(path, {}, session.progress()));
  const auto raster = std::make_shared<const HeightRaster>(std::move(read));
  wanted.samples = {raster, &raster->grid};
  wanted.samples_name = path;
  return {};
}

void add_raster(const TerrainRasterReport& report, const RasterForm& form, Json& json,
                Table& table) {
  const char* type = report.type == RasterType::float32 ? "float32" : "float64";
  const HeightFrame& frame = report.frame;
  const bool is_kept =
      form.nodata && static_cast<float>(*form.nodata) == static_cast<float>(report.nodata);
  Json& raster = json["raster"];
  raster["type"] = type;
  raster["columns"] = frame.n_columns;
  raster["rows"] = frame.n_rows;
  raster["to_world"] = frame.to_world;
  raster["heights"] = report.n_heights;
  // JSON has no NaN.
  raster["nodata"] = report.nodata == report.nodata ? Json(report.nodata) : Json("nan");
  raster["error"] = report.error;
  raster["error_kind"] = json_name_of(report.error_kind);
  raster["rounding"] = report.rounding;
  table.add({"raster", fmt::format("{} x {}, {}, {} with a height", frame.n_columns, frame.n_rows,
                                   type, format_count(report.n_heights))});
  table.add({"raster error", describe_error(report)});
  table.add({"rounding",
             fmt::format("heights are at most {} from the TIN", format_number(report.rounding))});
  table.add({"nodata", fmt::format("{}{}", report.nodata, is_kept ? ", as of the raster" : "")});
}

}  // namespace lode::cli
