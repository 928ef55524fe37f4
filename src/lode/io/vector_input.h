#pragma once

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/io/gdal_library.h"

namespace lode::io {

/// Whether the name is that of a file of features: .geojson, .json, .gpkg or .shp (any case).
[[nodiscard]] bool is_vector_path(const std::string& path);

/// A file of features, read through GDAL, whose messages are kept from stderr meanwhile: GeoJSON, a
/// GeoPackage or a shapefile.
class VectorInput {
 public:
  /// `what`: its features, in messages: "polygons".
  VectorInput(std::string path, const char* what, const GdalLibrary* gdal);
  VectorInput(const VectorInput&) = delete;
  VectorInput& operator=(const VectorInput&) = delete;
  ~VectorInput();

  /// Takes the geometry of a feature, or one of its parts, with chords for arcs, and its number.
  using Add = std::function<Result<void>(OGRGeometryH, GIntBig)>;
  /// Calls add() for all parts of all features of the only layer. Returns the CRS as WKT; empty:
  /// not known. Fails, naming the file and the feature.
  [[nodiscard]] Result<std::string> read(const Add& add) const;

  /// Takes the CRS of a layer, when all of its parts were added.
  using EndLayer = std::function<Result<void>(const std::string&)>;
  /// The same of all layers, one after the other.
  [[nodiscard]] Result<void> read_layers(const Add& add, const EndLayer& end_layer) const;

  /// That something else is there than is wanted.
  [[nodiscard]] Error other_than_wanted(OGRGeometryH geometry, GIntBig number) const;

 private:
  [[nodiscard]] std::string reason() const;
  [[nodiscard]] Result<void> check_open() const;
  [[nodiscard]] Result<OGRLayerH> only_layer() const;
  /// Whether it has features.
  [[nodiscard]] Result<bool> add_features(OGRLayerH layer, const Add& add) const;
  [[nodiscard]] Result<std::string> crs_of(OGRLayerH layer) const;
  [[nodiscard]] Result<void> add_feature(OGRFeatureH feature, const Add& add) const;
  [[nodiscard]] Result<void> add_parts(OGRGeometryH geometry, GIntBig number, const Add& add) const;

  std::string path_;
  const char* what_;
  const GdalLibrary* gdal_;
  GDALDatasetH dataset_ = nullptr;
};

/// From the CRS of a file of features, as WKT, to that of samples, x and y alone.
class PlaceTransform {
 public:
  /// `samples`: what they are, in messages: "points". Fails where one CRS alone is known.
  [[nodiscard]] static Result<PlaceTransform> make(const std::string& path, const std::string& from,
                                                   const std::string& to, const char* samples);
  PlaceTransform(PlaceTransform&& other) noexcept;
  PlaceTransform& operator=(PlaceTransform&&) = delete;
  ~PlaceTransform();

  /// Both CRS are the same, or neither is known.
  [[nodiscard]] bool is_identity() const { return way_ == nullptr; }
  /// Of places of two or three coordinates, of which the third stays. Fails, naming the file, on
  /// places that the CRS has not.
  template <std::size_t N>
  [[nodiscard]] Result<void> apply(std::span<Vec<double, N>> places) const {
    std::vector<double> x;
    std::vector<double> y;
    x.reserve(places.size());
    y.reserve(places.size());
    for (const auto& p : places) {
      x.push_back(p[0]);
      y.push_back(p[1]);
    }
    LODE_CHECK(apply(x, y));
    for (std::size_t i = 0; i < places.size(); ++i) {
      places[i][0] = x[i];
      places[i][1] = y[i];
    }
    return {};
  }

 private:
  [[nodiscard]] Result<void> apply(std::span<double> x, std::span<double> y) const;
  PlaceTransform(std::string path, const char* samples)
      : path_(std::move(path)), samples_(samples) {}

  std::string path_;
  const char* samples_;
  const GdalLibrary* gdal_ = nullptr;
  OGRCoordinateTransformationH way_ = nullptr;
};

}  // namespace lode::io
