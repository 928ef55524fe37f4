#include "lode/io/polygon_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/input_file.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

using Ring = PlacePolygon::value_type;

/// A file of features open in GDAL, whose messages are kept from stderr meanwhile.
class GdalFeatures {
 public:
  GdalFeatures(std::string path, const GdalLibrary* gdal) : path_(std::move(path)), gdal_(gdal) {
    gdal_->push_error_handler(gdal_->quiet_handler);
    gdal_->reset_errors();
    const std::array<const char*, 4> formats{"GeoJSON", "GPKG", "ESRI Shapefile", nullptr};
    dataset_ = gdal_->open(path_.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, formats.data(),
                           nullptr, nullptr);
  }
  GdalFeatures(const GdalFeatures&) = delete;
  GdalFeatures& operator=(const GdalFeatures&) = delete;
  ~GdalFeatures() {
    if (dataset_ != nullptr) gdal_->close(dataset_);
    gdal_->pop_error_handler();
  }

  Result<PolygonFile> read() {
    if (dataset_ == nullptr)
      return fail("{}: expected GeoJSON, a GeoPackage or a shapefile, got: {}", path_, reason());
    LODE_TRY(OGRLayerH layer, only_layer());
    PolygonFile file{.path = path_, .polygons = {}, .crs = {}};
    LODE_TRY(file.crs, crs_of(layer));
    gdal_->reset_errors();
    while (OGRFeatureH feature = gdal_->next_feature(layer)) {
      auto status = add_feature(feature, file.polygons);
      gdal_->destroy_feature(feature);
      if (!status) return status.error();
    }
    if (gdal_->last_error_kind() >= CE_Failure)
      return fail("{}: expected features to the end of the file, got: {}", path_, reason());
    if (file.polygons.empty()) return fail("{}: expected polygons, got no feature", path_);
    return file;
  }

 private:
  [[nodiscard]] std::string reason() const {
    const std::string text = without_controls(gdal_->last_error());
    return text.empty() ? "nothing that it knows" : text;
  }

  Result<OGRLayerH> only_layer() const {
    const int n = gdal_->n_layers(dataset_);
    if (n == 1) return gdal_->layer(dataset_, 0);
    std::string names;
    for (int i = 0; i < n; ++i)
      names +=
          (i == 0 ? ": " : ", ") + without_controls(gdal_->layer_name(gdal_->layer(dataset_, i)));
    return fail("{}: expected one layer, got {}{}", path_, n, names);
  }

  Result<std::string> crs_of(OGRLayerH layer) const {
    OGRSpatialReferenceH crs = gdal_->layer_crs(layer);
    if (crs == nullptr) return std::string();
    char* made = nullptr;
    const bool is_made = gdal_->export_wkt(crs, &made) == OGRERR_NONE && made != nullptr;
    const std::string wkt = is_made ? without_controls(made) : "";
    gdal_->release(made);
    if (!is_made) return fail("{}: expected a CRS that WKT can say, got another", path_);
    return wkt;
  }

  Result<void> add_feature(OGRFeatureH feature, std::vector<PlacePolygon>& polygons) const {
    const auto number = gdal_->feature_number(feature);
    OGRGeometryH own = gdal_->geometry(feature);
    if (own == nullptr)
      return fail("{}: expected polygons, got no geometry in feature {}", path_, number);
    OGRGeometryH linear = gdal_->linear_geometry(own, 0, nullptr);
    if (linear == nullptr)
      return fail("{}: expected polygons, got what has no chords in feature {}", path_, number);
    const std::size_t n_before = polygons.size();
    auto status = add_geometry(linear, number, polygons);
    gdal_->destroy_geometry(linear);
    if (!status) return status.error();
    if (polygons.size() == n_before)
      return fail("{}: expected polygons, got an empty geometry in feature {}", path_, number);
    return {};
  }

  Result<void> add_geometry(OGRGeometryH geometry, GIntBig number,
                            std::vector<PlacePolygon>& polygons) const {
    const OGRwkbGeometryType type = gdal_->flat_type(gdal_->geometry_type(geometry));
    const int n = gdal_->n_parts(geometry);
    if (type == wkbMultiPolygon || type == wkbGeometryCollection) {
      for (int i = 0; i < n; ++i)
        LODE_CHECK(add_geometry(gdal_->part(geometry, i), number, polygons));
      return {};
    }
    if (type != wkbPolygon)
      return fail("{}: expected polygons, got a {} in feature {}", path_,
                  to_lower(gdal_->geometry_name(geometry)), number);
    if (n == 0) return {};
    PlacePolygon polygon;
    for (int i = 0; i < n; ++i) {
      LODE_TRY(Ring ring, read_ring(gdal_->part(geometry, i), number));
      polygon.push_back(std::move(ring));
    }
    polygons.push_back(std::move(polygon));
    return {};
  }

  Result<Ring> read_ring(OGRGeometryH part, GIntBig number) const {
    Ring ring(static_cast<std::size_t>(std::max(0, gdal_->n_points(part))));
    static_assert(sizeof(Ring::value_type) == 2 * sizeof(double));
    constexpr int kStep = sizeof(Ring::value_type);
    if (!ring.empty())
      gdal_->points(part, ring.data()->v.data(), kStep, ring.data()->v.data() + 1, kStep, nullptr,
                    0);
    for (const auto& p : ring)
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]))
        return fail("{}: expected finite coordinates, got {}, {} in feature {}", path_, p[0], p[1],
                    number);
    while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
    if (ring.size() < 3)
      return fail("{}: expected rings of three corners or more, got {} in feature {}", path_,
                  ring.size(), number);
    return ring;
  }

  std::string path_;
  const GdalLibrary* gdal_;
  GDALDatasetH dataset_ = nullptr;
};

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

/// In the coordinates of `to`, where `from` is not the same.
Result<std::vector<PlacePolygon>> transformed(const PolygonFile& file, const GdalCrs& from,
                                              const GdalCrs& to) {
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  OGRCoordinateTransformationH way = gdal->new_transformation(from.handle(), to.handle());
  if (way == nullptr)
    return fail("{}: expected a CRS that can be transformed to that of the points, got another",
                file.path);
  std::vector<PlacePolygon> polygons = file.polygons;
  const double step = longest_step(polygons);
  std::vector<double> x;
  std::vector<double> y;
  bool is_done = true;
  for (PlacePolygon& polygon : polygons)
    for (Ring& ring : polygon) {
      ring = divided(ring, step);
      x.clear();
      y.clear();
      for (const auto& p : ring) {
        x.push_back(p[0]);
        y.push_back(p[1]);
      }
      is_done = is_done && gdal->transform(way, static_cast<int>(ring.size()), x.data(), y.data(),
                                           nullptr) != 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        ring[i] = {{x[i], y[i]}};
        is_done = is_done && std::isfinite(x[i]) && std::isfinite(y[i]);
      }
    }
  gdal->destroy_transformation(way);
  if (!is_done)
    return fail("{}: expected places that the CRS of the points has, got others", file.path);
  return polygons;
}

}  // namespace

bool is_polygon_path(const std::string& path) {
  const std::string name = to_lower(path);
  constexpr std::array kExtensions{".geojson", ".json", ".gpkg", ".shp"};
  return std::ranges::any_of(kExtensions,
                             [&](const char* extension) { return name.ends_with(extension); });
}

Result<PolygonFile> read_polygons(const std::string& path) try {
  if (!is_polygon_path(path))
    return fail("{}: expected a file that ends in .geojson, .json, .gpkg or .shp", path);
  // GDAL takes URLs and the text of some formats for names, too.
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  return GdalFeatures(path, gdal).read();
} catch (const std::bad_alloc&) {
  return out_of_memory("read the polygons", path);
}

Result<std::vector<PlacePolygon>> polygons_in(const PolygonFile& file, const std::string& crs) try {
  if (file.crs.empty() && crs.empty()) return file.polygons;
  if (file.crs.empty())
    return fail(
        "{}: expected a file that says its CRS, as that of the points is known, got none (of a "
        "shapefile the .prj beside it says it)",
        file.path);
  if (crs.empty())
    return fail("{}: expected points whose CRS is known, as that of the file is (--crs says it)",
                file.path);
  LODE_TRY(const GdalCrs from, GdalCrs::of(file.crs));
  LODE_TRY(const GdalCrs to, GdalCrs::of(crs));
  from.strip_heights();
  to.strip_heights();
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  if (gdal->is_same_crs(from.handle(), to.handle()) != 0) return file.polygons;
  return transformed(file, from, to);
} catch (const std::bad_alloc&) {
  return out_of_memory("transform the polygons", file.path);
}

}  // namespace lode::io
