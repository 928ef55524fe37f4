#include "lode/io/vector_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/text.h"

namespace lode::io {

namespace {

/// What GDAL says of GeoPackages with srs_id -1 and 0, which know of no CRS.
bool is_undefined_crs(const std::string& wkt) {
  return wkt.starts_with(R"(LOCAL_CS["Undefined Cartesian SRS")") ||
         wkt.starts_with(R"(ENGCRS["Undefined Cartesian SRS")") ||
         wkt.starts_with(R"(GEOGCS["Undefined geographic SRS")");
}

}  // namespace

bool is_vector_path(const std::string& path) {
  const std::string name = to_lower(path);
  constexpr std::array kExtensions{".geojson", ".json", ".gpkg", ".shp"};
  return std::ranges::any_of(kExtensions,
                             [&](const char* extension) { return name.ends_with(extension); });
}

VectorInput::VectorInput(std::string path, const char* what, const GdalLibrary* gdal)
    : path_(std::move(path)), what_(what), gdal_(gdal) {
  gdal_->push_error_handler(gdal_->quiet_handler);
  gdal_->reset_errors();
  const std::array<const char*, 4> formats{"GeoJSON", "GPKG", "ESRI Shapefile", nullptr};
  dataset_ = gdal_->open(path_.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, formats.data(), nullptr,
                         nullptr);
}

VectorInput::~VectorInput() {
  if (dataset_ != nullptr) gdal_->close(dataset_);
  gdal_->pop_error_handler();
}

Result<std::string> VectorInput::read(const Add& add) const {
  LODE_CHECK(check_open());
  LODE_TRY(OGRLayerH layer, only_layer());
  LODE_TRY(std::string crs, crs_of(layer));
  LODE_TRY(const bool has_features, add_features(layer, add));
  if (!has_features) return fail("{}: expected {}, got no feature", path_, what_);
  return crs;
}

Result<void> VectorInput::read_layers(const Add& add, const EndLayer& end_layer) const {
  LODE_CHECK(check_open());
  bool has_features = false;
  for (int i = 0; i < gdal_->n_layers(dataset_); ++i) {
    OGRLayerH layer = gdal_->layer(dataset_, i);
    LODE_TRY(const std::string crs, crs_of(layer));
    LODE_TRY(const bool has_own, add_features(layer, add));
    LODE_CHECK(end_layer(crs));
    has_features = has_features || has_own;
  }
  if (!has_features) return fail("{}: expected {}, got no feature", path_, what_);
  return {};
}

Result<void> VectorInput::check_open() const {
  if (dataset_ != nullptr) return {};
  return fail("{}: expected GeoJSON, a GeoPackage or a shapefile, got: {}", path_, reason());
}

Result<bool> VectorInput::add_features(OGRLayerH layer, const Add& add) const {
  gdal_->reset_errors();
  bool has_features = false;
  while (OGRFeatureH feature = gdal_->next_feature(layer)) {
    has_features = true;
    auto status = add_feature(feature, add);
    gdal_->destroy_feature(feature);
    if (!status) return status.error();
  }
  if (gdal_->last_error_kind() >= CE_Failure)
    return fail("{}: expected features to the end of the file, got: {}", path_, reason());
  return has_features;
}

Error VectorInput::other_than_wanted(OGRGeometryH geometry, GIntBig number) const {
  return fail("{}: expected {}, got a {} in feature {}", path_, what_,
              to_lower(gdal_->geometry_name(geometry)), number);
}

std::string VectorInput::reason() const {
  const std::string text = without_controls(gdal_->last_error());
  return text.empty() ? "nothing that it knows" : text;
}

Result<OGRLayerH> VectorInput::only_layer() const {
  const int n = gdal_->n_layers(dataset_);
  if (n == 1) return gdal_->layer(dataset_, 0);
  std::string names;
  for (int i = 0; i < n; ++i)
    names +=
        (i == 0 ? ": " : ", ") + without_controls(gdal_->layer_name(gdal_->layer(dataset_, i)));
  return fail("{}: expected one layer, got {}{}", path_, n, names);
}

Result<std::string> VectorInput::crs_of(OGRLayerH layer) const {
  OGRSpatialReferenceH crs = gdal_->layer_crs(layer);
  if (crs == nullptr) return std::string();
  char* made = nullptr;
  const bool is_made = gdal_->export_wkt(crs, &made) == OGRERR_NONE && made != nullptr;
  const std::string wkt = is_made ? without_controls(made) : "";
  gdal_->release(made);
  if (!is_made) return fail("{}: expected a CRS that WKT can say, got another", path_);
  return is_undefined_crs(wkt) ? std::string() : wkt;
}

Result<void> VectorInput::add_feature(OGRFeatureH feature, const Add& add) const {
  const auto number = gdal_->feature_number(feature);
  OGRGeometryH own = gdal_->geometry(feature);
  if (own == nullptr)
    return fail("{}: expected {}, got no geometry in feature {}", path_, what_, number);
  OGRGeometryH linear = gdal_->linear_geometry(own, 0, nullptr);
  if (linear == nullptr)
    return fail("{}: expected {}, got what has no chords in feature {}", path_, what_, number);
  bool is_empty = true;
  auto status = add_parts(linear, number, [&](OGRGeometryH part, GIntBig feature_number) {
    is_empty = false;
    return add(part, feature_number);
  });
  gdal_->destroy_geometry(linear);
  if (!status) return status.error();
  if (is_empty)
    return fail("{}: expected {}, got an empty geometry in feature {}", path_, what_, number);
  return {};
}

Result<void> VectorInput::add_parts(OGRGeometryH geometry, GIntBig number, const Add& add) const {
  const OGRwkbGeometryType type = gdal_->flat_type(gdal_->geometry_type(geometry));
  const bool has_parts = type == wkbMultiPolygon || type == wkbMultiLineString ||
                         type == wkbMultiPoint || type == wkbGeometryCollection;
  if (!has_parts) {
    const int n = type == wkbPolygon ? gdal_->n_parts(geometry) : gdal_->n_points(geometry);
    return n > 0 ? add(geometry, number) : Result<void>();
  }
  for (int i = 0; i < gdal_->n_parts(geometry); ++i)
    LODE_CHECK(add_parts(gdal_->part(geometry, i), number, add));
  return {};
}

Result<PlaceTransform> PlaceTransform::make(const std::string& path, const std::string& from,
                                            const std::string& to, const char* samples) {
  PlaceTransform made(path, samples);
  if (from.empty() && to.empty()) return made;
  if (from.empty())
    return fail(
        "{}: expected a file that says its CRS, as that of the {} is known, got none (of a "
        "shapefile the .prj beside it says it)",
        path, samples);
  if (to.empty())
    return fail("{}: expected {} whose CRS is known, as that of the file is (--crs says it)", path,
                samples);
  LODE_TRY(const GdalCrs source, GdalCrs::of(from));
  LODE_TRY(const GdalCrs target, GdalCrs::of(to));
  source.strip_heights();
  target.strip_heights();
  LODE_TRY(made.gdal_, GdalLibrary::get());
  if (made.gdal_->is_same_crs(source.handle(), target.handle()) != 0) return made;
  made.way_ = made.gdal_->new_transformation(source.handle(), target.handle());
  if (made.way_ == nullptr)
    return fail("{}: expected a CRS that can be transformed to that of the {}, got another", path,
                samples);
  return made;
}

PlaceTransform::PlaceTransform(PlaceTransform&& other) noexcept
    : path_(std::move(other.path_)),
      samples_(other.samples_),
      gdal_(other.gdal_),
      way_(std::exchange(other.way_, nullptr)) {}

PlaceTransform::~PlaceTransform() {
  if (way_ != nullptr) gdal_->destroy_transformation(way_);
}

Result<void> PlaceTransform::apply(std::span<double> x, std::span<double> y) const {
  if (is_identity() || x.empty()) return {};
  bool is_done =
      gdal_->transform(way_, static_cast<int>(x.size()), x.data(), y.data(), nullptr) != 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    is_done = is_done && std::isfinite(x[i]) && std::isfinite(y[i]);
  if (!is_done)
    return fail("{}: expected places that the CRS of the {} has, got others", path_, samples_);
  return {};
}

}  // namespace lode::io
