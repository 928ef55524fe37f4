#include "lode/io/line_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/input_file.h"
#include "lode/io/vector_input.h"

namespace lode::io {
namespace {

/// Of a line, or of a ring.
Result<PlaceLine> read_line(const std::string& path, const GdalLibrary& gdal, OGRGeometryH geometry,
                            GIntBig number) {
  PlaceLine line(static_cast<std::size_t>(std::max(0, gdal.n_points(geometry))));
  static_assert(sizeof(Vec3d) == 3 * sizeof(double));
  constexpr int kStep = sizeof(Vec3d);
  if (line.size() < 2)
    return fail("{}: expected lines of two points or more, got {} in feature {}", path, line.size(),
                number);
  double* first = line.data()->v.data();
  gdal.points(geometry, first, kStep, first + 1, kStep, first + 2, kStep);
  const bool has_heights = gdal.has_heights(gdal.geometry_type(geometry)) != 0;
  for (Vec3d& p : line) {
    if (!has_heights) p[2] = std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || std::isinf(p[2]))
      return fail("{}: expected finite coordinates, got {}, {}, {} in feature {}", path, p[0], p[1],
                  p[2], number);
  }
  return line;
}

}  // namespace

Result<LineFile> read_lines(const std::string& path, const std::string& crs) try {
  if (!is_vector_path(path))
    return fail("{}: expected a file that ends in .geojson, .json, .gpkg or .shp", path);
  // GDAL takes URLs and the text of some formats for names, too.
  LODE_TRY(const InputFilePtr opened, InputFile::open(path));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  const VectorInput input(path, "lines", gdal);
  LineFile file;
  std::vector<PlaceLine>& lines = file.lines;
  std::optional<Error> first_point;
  const auto add = [&](OGRGeometryH geometry, GIntBig number) -> Result<void> {
    const OGRwkbGeometryType type = gdal->flat_type(gdal->geometry_type(geometry));
    if (type == wkbPoint) {
      ++file.n_points;
      if (!first_point) first_point = input.other_than_wanted(geometry, number);
      return {};
    }
    const bool is_polygon = type == wkbPolygon;
    if (!is_polygon && type != wkbLineString) return input.other_than_wanted(geometry, number);
    const int n = is_polygon ? gdal->n_parts(geometry) : 1;
    for (int i = 0; i < n; ++i) {
      LODE_TRY(PlaceLine line,
               read_line(path, *gdal, is_polygon ? gdal->part(geometry, i) : geometry, number));
      lines.push_back(std::move(line));
    }
    return {};
  };
  std::size_t n_placed = 0;
  const auto end_layer = [&](const std::string& own_crs) -> Result<void> {
    if (n_placed == lines.size()) return {};
    LODE_TRY(const PlaceTransform way, PlaceTransform::make(path, own_crs, crs, "samples"));
    for (; n_placed < lines.size(); ++n_placed) LODE_CHECK(way.apply(std::span(lines[n_placed])));
    return {};
  };
  LODE_CHECK(input.read_layers(add, end_layer));
  if (lines.empty() && first_point) return *first_point;
  return file;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the lines", path);
}

}  // namespace lode::io
