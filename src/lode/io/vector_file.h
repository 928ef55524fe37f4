#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

/// mixed: points and lines.
enum class VectorShape : std::uint8_t { points, lines, polygons, mixed };

enum class ColumnType : std::uint8_t { number, integer, text };

struct VectorColumn {
  std::string name;
  ColumnType type = ColumnType::number;
};

/// What a layer has for all of its features.
struct VectorLayer {
  std::string name;
  VectorShape shape = VectorShape::lines;
  std::vector<VectorColumn> columns;
  std::string crs;           ///< As WKT; empty: not known.
  bool has_heights = false;  ///< Points and lines have them, but in GeoJSON.
};

/// Nothing where a feature has no such value, which GeoJSON then leaves out; infinite numbers are
/// null.
using VectorValue = std::variant<std::monostate, double, std::string_view>;

/// A GeoPackage (.gpkg) of layers or GeoJSON file (.geojson) of one, written through GDAL feature
/// by feature, whole or not at all. A GeoPackage has the layers' CRS, and coordinates as they are.
/// GeoJSON is that of RFC 7946: longitudes and latitudes of WGS 84 with seven decimals, to which
/// GDAL transforms; so it needs a CRS. Heights there would be metres above the ellipsoid, and are
/// left out. Outer rings turn left.
class VectorWriter {
 public:
  /// Fails on other names, naming the file, and where GDAL is not installed.
  [[nodiscard]] static Result<VectorWriter> create(const std::string& path,
                                                   std::span<const VectorLayer> layers);
  [[nodiscard]] static Result<VectorWriter> create(const std::string& path,
                                                   const VectorLayer& layer) {
    return create(path, {&layer, 1});
  }

  VectorWriter(VectorWriter&&) noexcept;
  VectorWriter& operator=(VectorWriter&&) = delete;
  ~VectorWriter();

  using Points = std::vector<Vec<double, 2>>;
  /// To the first layer, which has no heights, as many values as columns. Of lines one run of
  /// points; of a polygon its outer ring, then its inner ones, each closed.
  [[nodiscard]] Result<void> add(std::span<const double> values, std::span<const Points> parts);
  /// The same with values of any kind.
  [[nodiscard]] Result<void> add(std::span<const VectorValue> values,
                                 std::span<const Points> parts);
  /// One place is a point, several are a line; the third coordinate is its height.
  [[nodiscard]] Result<void> add(std::size_t layer, std::span<const VectorValue> values,
                                 std::span<const Vec3d> places);
  /// Nothing may be added after.
  [[nodiscard]] Result<void> commit(const Progress& progress);

 private:
  struct Impl;
  explicit VectorWriter(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

/// Fails, listing the known extensions, unless `path` ends in one of them.
[[nodiscard]] Result<void> check_vector_path(const std::string& path);
/// Whether it is written in longitudes and latitudes, and so needs a CRS.
[[nodiscard]] bool is_geojson_path(const std::string& path);

}  // namespace lode::io
