#include "lode/io/polygon_file.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/input_file.h"
#include "lode/io/vector_input.h"

namespace lode::io {
namespace {

using Ring = PlacePolygon::value_type;

Result<Ring> read_ring(const std::string& path, const GdalLibrary& gdal, OGRGeometryH part,
                       GIntBig number) {
  Ring ring(static_cast<std::size_t>(std::max(0, gdal.n_points(part))));
  static_assert(sizeof(Ring::value_type) == 2 * sizeof(double));
  constexpr int kStep = sizeof(Ring::value_type);
  if (!ring.empty())
    gdal.points(part, ring.data()->v.data(), kStep, ring.data()->v.data() + 1, kStep, nullptr, 0);
  for (const auto& p : ring)
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]))
      return fail("{}: expected finite coordinates, got {}, {} in feature {}", path, p[0], p[1],
                  number);
  while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
  if (ring.size() < 3)
    return fail("{}: expected rings of three corners or more, got {} in feature {}", path,
                ring.size(), number);
  return ring;
}

/// A 64th of the longer side of all polygons.
double longest_step(const std::vector<PlacePolygon>& polygons) {
  Vec<double, 2> lower = polygons[0][0][0];
  Vec<double, 2> upper = lower;
  for (const PlacePolygon& polygon : polygons)
    for (const Ring& ring : polygon)
      for (const auto& p : ring)
        for (std::size_t i = 0; i < 2; ++i) {
          lower[i] = std::min(lower[i], p[i]);
          upper[i] = std::max(upper[i], p[i]);
        }
  constexpr double kSteps = 64;
  return std::max(upper[0] - lower[0], upper[1] - lower[1]) / kSteps;
}

/// With corners on edges that are longer than a step.
Ring divided(const Ring& ring, double step) {
  Ring fine;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const auto& a = ring[i];
    const auto& b = ring[i + 1 < ring.size() ? i + 1 : 0];
    const double n = step > 0 ? std::max(1.0, std::ceil(length(b - a) / step)) : 1;
    for (double k = 0; k < n; ++k) fine.push_back(a * (1 - k / n) + b * (k / n));
  }
  return fine;
}

/// All rings, divided, in the coordinates of the points.
Result<std::vector<PlacePolygon>> transformed(const PolygonFile& file, const PlaceTransform& way) {
  std::vector<PlacePolygon> polygons = file.polygons;
  const double step = longest_step(polygons);
  for (PlacePolygon& polygon : polygons)
    for (Ring& ring : polygon) {
      ring = divided(ring, step);
      LODE_CHECK(way.apply(std::span(ring)));
    }
  return polygons;
}

}  // namespace

bool is_polygon_path(const std::string& path) { return is_vector_path(path); }

Result<PolygonFile> read_polygons(const std::string& path) try {
  if (!is_polygon_path(path))
    return fail("{}: expected a file that ends in .geojson, .json, .gpkg or .shp", path);
  // GDAL takes URLs and the text of some formats for names, too.
  LODE_TRY(const InputFilePtr opened, InputFile::open(path));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  const VectorInput input(path, "polygons", gdal);
  PolygonFile file{.path = path, .polygons = {}, .crs = {}};
  LODE_TRY(file.crs, input.read([&](OGRGeometryH geometry, GIntBig number) -> Result<void> {
    if (gdal->flat_type(gdal->geometry_type(geometry)) != wkbPolygon)
      return input.other_than_wanted(geometry, number);
    PlacePolygon& polygon = file.polygons.emplace_back();
    for (int i = 0; i < gdal->n_parts(geometry); ++i) {
      LODE_TRY(Ring ring, read_ring(path, *gdal, gdal->part(geometry, i), number));
      polygon.push_back(std::move(ring));
    }
    return {};
  }));
  return file;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the polygons", path);
}

Result<std::vector<PlacePolygon>> polygons_in(const PolygonFile& file, const std::string& crs) try {
  LODE_TRY(const PlaceTransform way, PlaceTransform::make(file.path, file.crs, crs, "points"));
  if (way.is_identity()) return file.polygons;
  return transformed(file, way);
} catch (const std::bad_alloc&) {
  return out_of_memory("transform the polygons", file.path);
}

}  // namespace lode::io
