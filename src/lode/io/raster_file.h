#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode::io {

enum class RasterType : std::uint8_t { float32, float64 };

/// What a raster of one band has beside its samples.
struct RasterLayer {
  std::int32_t n_columns = 0;
  std::int32_t n_rows = 0;
  RasterType type = RasterType::float32;
  double nodata = 0;                                  ///< Of the type, or NaN.
  std::optional<std::array<double, 6>> geotransform;  ///< GDAL's: of pixels' corners.
  bool is_point = false;                              ///< AREA_OR_POINT=Point, else Area.
  std::string crs{};                                  ///< As WKT; empty: not known.
  std::string unit{};                                 ///< Of samples; empty: not known.
  std::string name{};                                 ///< Of the band.
  std::string comment{};
};

/// A GeoTIFF written through GDAL in rows from the first on, in tiles of 256 x 256 that are
/// deflated after GDAL's predictor for floats; BigTIFF where 4 GB may not do. Whole or not at all.
class RasterWriter {
 public:
  static constexpr std::int32_t kTileRows = 256;

  /// Fails on other names, naming the file, and where GDAL is not installed.
  [[nodiscard]] static Result<RasterWriter> create(const std::string& path,
                                                   const RasterLayer& layer);

  RasterWriter(RasterWriter&&) noexcept;
  RasterWriter& operator=(RasterWriter&&) = delete;
  ~RasterWriter();

  /// The next rows, whole: kTileRows of them until the last. Samples that the type holds are stored
  /// as they are, others rounded to the nearest.
  [[nodiscard]] Result<void> add_rows(std::span<const double> samples);
  /// After the last row.
  [[nodiscard]] Result<void> commit(const Progress& progress);

 private:
  struct Impl;
  explicit RasterWriter(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

/// Whether `path` ends in .tif or .tiff (any case).
[[nodiscard]] bool is_geotiff_path(const std::string& path);

}  // namespace lode::io
