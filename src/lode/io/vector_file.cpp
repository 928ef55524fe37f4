#include "lode/io/vector_file.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <new>
#include <optional>
#include <utility>

#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/staged_file.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

bool has_extension(const std::string& path, std::string_view extension) {
  return to_lower(std::filesystem::path(path).extension().string()) == extension;
}

OGRwkbGeometryType geometry_type_of(VectorShape shape, bool has_heights) {
  switch (shape) {
    case VectorShape::points: return has_heights ? wkbPoint25D : wkbPoint;
    case VectorShape::lines: return has_heights ? wkbLineString25D : wkbLineString;
    case VectorShape::polygons: return wkbPolygon;
    case VectorShape::mixed: return wkbUnknown;
  }
  return wkbUnknown;
}

OGRFieldType field_type_of(ColumnType type) {
  switch (type) {
    case ColumnType::number: return OFTReal;
    case ColumnType::integer: return OFTInteger;
    case ColumnType::text: return OFTString;
  }
  return OFTString;
}

}  // namespace

bool is_geojson_path(const std::string& path) { return has_extension(path, ".geojson"); }

Result<void> check_vector_path(const std::string& path) {
  if (has_extension(path, ".gpkg") || is_geojson_path(path)) return {};
  return fail("{}: expected a file that ends in .gpkg or .geojson", path);
}

struct VectorWriter::Impl {
  const GdalLibrary* gdal;
  std::string path;
  StagedFile staged;
  GDALDatasetH dataset = nullptr;
  std::vector<VectorLayer> facts;  ///< Of layers.
  std::vector<OGRLayerH> layers{};

  Impl(const GdalLibrary* library, std::string file, std::span<const VectorLayer> wanted,
       StagedFile stage)
      : gdal(library),
        path(std::move(file)),
        staged(std::move(stage)),
        facts(wanted.begin(), wanted.end()) {
    gdal->push_error_handler(gdal->quiet_handler);
    gdal->reset_errors();
    // What is staged is flushed once, before it gets its name.
    gdal->set_option("OGR_SQLITE_SYNCHRONOUS", "OFF");
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (dataset != nullptr) gdal->close(dataset);
    gdal->set_option("OGR_SQLITE_SYNCHRONOUS", nullptr);
    gdal->pop_error_handler();
  }

  [[nodiscard]] Error refused(const char* action) const {
    const std::string reason = without_controls(gdal->last_error());
    return fail("{}: cannot {}: {}", path, action, reason.empty() ? "GDAL says no more" : reason);
  }

  Result<void> open() {
    const bool is_geojson = is_geojson_path(path);
    GDALDriverH driver = gdal->driver_named(is_geojson ? "GeoJSON" : "GPKG");
    if (driver == nullptr)
      return fail("{}: expected a GDAL that writes {}, got one that does not", path,
                  is_geojson ? "GeoJSON" : "GeoPackage");
    dataset = gdal->create(driver, staged.name().c_str(), 0, 0, 0, GDT_Unknown, nullptr);
    if (dataset == nullptr) return refused("make the file");
    for (VectorLayer& layer : facts) {
      // RFC 7946 has them in metres above the ellipsoid, and these are above what heights are.
      if (is_geojson) layer.has_heights = false;
      LODE_CHECK(open_layer(layer));
    }
    // GeoJSON has none; a GeoPackage would otherwise have one a feature.
    if (!is_geojson && gdal->start_transaction(dataset, 0) != OGRERR_NONE)
      return refused("start a transaction");
    return {};
  }

  Result<void> open_layer(const VectorLayer& wanted) {
    const bool is_geojson = is_geojson_path(path);
    std::optional<GdalCrs> crs;
    if (wanted.crs.empty() && !is_geojson) {
      // Else GDAL says srs_id 0, which is of angles; coordinates of no CRS are taken as in a plane.
      LODE_TRY(GdalCrs plane,
               GdalCrs::of(R"(LOCAL_CS["Undefined Cartesian SRS",UNIT["metre",1]])"));
      crs.emplace(std::move(plane));
    } else if (!wanted.crs.empty()) {
      LODE_TRY(GdalCrs read, GdalCrs::of(wanted.crs));
      if (is_geojson) read.strip_heights();
      crs.emplace(std::move(read));
    }
    std::array<char*, 2> options{nullptr, nullptr};
    std::string rfc = "RFC7946=YES";
    if (is_geojson) options[0] = rfc.data();
    OGRLayerH layer =
        gdal->new_layer(dataset, wanted.name.c_str(), crs ? crs->handle() : nullptr,
                        geometry_type_of(wanted.shape, wanted.has_heights), options.data());
    if (layer == nullptr) return refused("make its layer");
    layers.push_back(layer);
    for (const VectorColumn& column : wanted.columns) {
      OGRFieldDefnH field = gdal->new_field(column.name.c_str(), field_type_of(column.type));
      const OGRErr status = gdal->add_field(layer, field, 1);
      gdal->destroy_field(field);
      if (status != OGRERR_NONE) return refused("make its columns");
    }
    return {};
  }

  [[nodiscard]] OGRGeometryH to_geometry(OGRwkbGeometryType type, const Points& points) const {
    OGRGeometryH geometry = gdal->new_geometry(type);
    static_assert(sizeof(Points::value_type) == 2 * sizeof(double));
    gdal->set_points(geometry, static_cast<int>(points.size()), points.data(),
                     sizeof(Points::value_type), points.data()->v.data() + 1,
                     sizeof(Points::value_type), nullptr, 0);
    return geometry;
  }

  [[nodiscard]] OGRGeometryH to_geometry(std::span<const Vec3d> places, bool has_heights) const {
    OGRGeometryH geometry = gdal->new_geometry(geometry_type_of(
        places.size() == 1 ? VectorShape::points : VectorShape::lines, has_heights));
    static_assert(sizeof(Vec3d) == 3 * sizeof(double));
    constexpr int kStride = sizeof(Vec3d);
    const double* first = places.data()->v.data();
    gdal->set_points(geometry, static_cast<int>(places.size()), first, kStride, first + 1, kStride,
                     has_heights ? first + 2 : nullptr, has_heights ? kStride : 0);
    return geometry;
  }

  void set_value(OGRFeatureH feature, int column, const VectorValue& value) const {
    if (const auto* text = std::get_if<std::string_view>(&value)) {
      gdal->set_text(feature, column, std::string(*text).c_str());
    } else if (const auto* number = std::get_if<double>(&value)) {
      if (std::isfinite(*number))
        gdal->set_number(feature, column, *number);
      else
        gdal->set_null(feature, column);
    }
  }

  /// Takes the feature.
  Result<void> add_feature(OGRLayerH layer, OGRFeatureH feature) const {
    const OGRErr status = gdal->add_feature(layer, feature);
    gdal->destroy_feature(feature);
    if (status != OGRERR_NONE) return refused("write a feature");
    return {};
  }
};

VectorWriter::VectorWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VectorWriter::VectorWriter(VectorWriter&&) noexcept = default;
VectorWriter::~VectorWriter() = default;

Result<VectorWriter> VectorWriter::create(const std::string& path,
                                          std::span<const VectorLayer> layers) try {
  LODE_CHECK(check_vector_path(path));
  LODE_EXPECTS(layers.size() == 1 || (!layers.empty() && !is_geojson_path(path)));
  if (is_geojson_path(path) && layers.front().crs.empty())
    return fail(
        "{}: expected a known CRS, as GeoJSON has longitudes and latitudes of WGS 84 (RFC 7946), "
        "got none; .gpkg takes coordinates as they are",
        path);
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  LODE_TRY(StagedFile staged, StagedFile::create(path));
  auto impl = std::make_unique<Impl>(gdal, path, layers, std::move(staged));
  LODE_CHECK(impl->open());
  return VectorWriter(std::move(impl));
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", path);
}

Result<void> VectorWriter::add(std::span<const double> values, std::span<const Points> parts) try {
  std::vector<VectorValue> all;
  all.reserve(values.size());
  for (const double value : values) all.emplace_back(value);
  return add(all, parts);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", impl_->path);
}

Result<void> VectorWriter::add(std::span<const VectorValue> values,
                               std::span<const Points> parts) try {
  const GdalLibrary& gdal = *impl_->gdal;
  OGRLayerH layer = impl_->layers.front();
  OGRFeatureH feature = gdal.new_feature(gdal.layer_definition(layer));
  for (std::size_t i = 0; i < values.size(); ++i)
    impl_->set_value(feature, static_cast<int>(i), values[i]);
  OGRGeometryH shape = nullptr;
  if (impl_->facts.front().shape == VectorShape::lines) {
    LODE_EXPECTS(parts.size() == 1);
    shape = impl_->to_geometry(wkbLineString, parts[0]);
  } else {
    shape = gdal.new_geometry(wkbPolygon);
    for (const Points& ring : parts)
      gdal.add_geometry(shape, impl_->to_geometry(wkbLinearRing, ring));
  }
  gdal.set_geometry(feature, shape);
  return impl_->add_feature(layer, feature);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", impl_->path);
}

Result<void> VectorWriter::add(std::size_t layer, std::span<const VectorValue> values,
                               std::span<const Vec3d> places) try {
  LODE_EXPECTS(layer < impl_->layers.size() && !places.empty());
  const VectorLayer& facts = impl_->facts[layer];
  LODE_EXPECTS(values.size() == facts.columns.size() && facts.shape != VectorShape::polygons);
  const GdalLibrary& gdal = *impl_->gdal;
  OGRFeatureH feature = gdal.new_feature(gdal.layer_definition(impl_->layers[layer]));
  for (std::size_t i = 0; i < values.size(); ++i)
    impl_->set_value(feature, static_cast<int>(i), values[i]);
  gdal.set_geometry(feature, impl_->to_geometry(places, facts.has_heights));
  return impl_->add_feature(impl_->layers[layer], feature);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", impl_->path);
}

Result<void> VectorWriter::commit(const Progress& progress) try {
  const GdalLibrary& gdal = *impl_->gdal;
  if (!is_geojson_path(impl_->path) && gdal.commit_transaction(impl_->dataset) != OGRERR_NONE)
    return impl_->refused("end the transaction");
  // Closing writes what is left, and says nothing but by messages.
  gdal.reset_errors();
  gdal.close(std::exchange(impl_->dataset, nullptr));
  if (gdal.last_error_kind() >= CE_Failure) return impl_->refused("finish the file");
  return impl_->staged.commit(progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", impl_->path);
}

}  // namespace lode::io
