#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

enum class VectorShape : std::uint8_t { lines, polygons };

/// What a file of features has for all of them.
struct VectorLayer {
  std::string name;
  VectorShape shape = VectorShape::lines;
  std::vector<std::string> columns;  ///< Each of a number.
  std::string crs;                   ///< As WKT; empty: not known.
};

/// A GeoPackage (.gpkg) or GeoJSON file (.geojson) of one layer, written through GDAL feature by
/// feature, whole or not at all. A GeoPackage has the layer's CRS, and its coordinates as they are.
/// GeoJSON is that of RFC 7946: longitudes and latitudes of WGS 84 with seven decimals, to which
/// GDAL transforms; so it needs a CRS. Outer rings turn left.
class VectorWriter {
 public:
  /// Fails on other names, naming the file, and where GDAL is not installed.
  [[nodiscard]] static Result<VectorWriter> create(const std::string& path,
                                                   const VectorLayer& layer);

  VectorWriter(VectorWriter&&) noexcept;
  VectorWriter& operator=(VectorWriter&&) = delete;
  ~VectorWriter();

  using Points = std::vector<Vec<double, 2>>;
  /// Of as many values as columns. Of lines one run of points; of a polygon its outer ring, then
  /// its inner ones, each closed.
  [[nodiscard]] Result<void> add(std::span<const double> values, std::span<const Points> parts);
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
