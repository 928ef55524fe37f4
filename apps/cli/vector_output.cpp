#include "vector_output.h"

#include "outputs.h"

namespace lode::cli {

bool is_vtp_path(const std::string& path) { return check_extension(path, ".vtp").has_value(); }

Result<void> check_line_output(const std::string& path) {
  if (is_vtp_path(path) || check_vector_path(path)) return {};
  return fail("{}: expected an output that ends in .gpkg, .geojson or .vtp", path);
}

Result<void> check_known_crs(const std::string& output, const std::string& input,
                             const TerrainFacts& facts) {
  if (!is_geojson_path(output) || !facts.frame.crs.empty()) return {};
  return fail(
      "{}: expected a raster whose CRS is known, as GeoJSON has longitudes and latitudes of WGS 84 "
      "(RFC 7946), got {}, which has none (--crs says it); .gpkg takes coordinates as they are",
      output, input);
}

}  // namespace lode::cli
