#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"
#include "lode/models/terrain/tile_pyramid/height_rows.h"

namespace lode {

/// Rows of a raster in metres, which counts what is missing as it is read for the first time.
class TileRows : public tile_pyramid::HeightRows {
 public:
  [[nodiscard]] Result<void> read(std::int32_t first, std::int32_t n_rows,
                                  std::span<double> out) final;
  [[nodiscard]] std::string name() const final { return path_; }
  /// Of the rows read so far.
  [[nodiscard]] std::uint64_t n_missing() const { return n_missing_; }

 protected:
  TileRows(std::string path, double metres) : path_(std::move(path)), metres_(metres) {}
  [[nodiscard]] virtual Result<void> read_own(std::int32_t first, std::int32_t n_rows,
                                              std::span<double> out) = 0;

 private:
  std::string path_;
  double metres_;
  std::int32_t n_counted_ = 0;
  std::uint64_t n_missing_ = 0;
};

/// A raster that tiles may be made of, or held against.
struct TileRaster {
  std::unique_ptr<TileRows> rows;
  std::string type;          ///< See HeightRaster, and so the next.
  bool is_in_memory = true;  ///< Else it stays in its file.
  io::VerticalOutcome vertical;
  std::vector<std::string> notes;  ///< Of what was taken for granted.
};

/// Opens a raster in degrees, and puts its heights above the ellipsoid where it is known what they
/// are above. One that would take more than `most_bytes` stays in its file and is read again, and
/// its heights transformed, whenever it is needed. Fails on rasters that are not
/// in degrees, on units of heights that are not known, and as reading does.
[[nodiscard]] Result<TileRaster> open_tile_raster(const std::string& path,
                                                  const io::HeightReadOptions& reading,
                                                  std::uint64_t most_bytes, Progress& progress);

}  // namespace lode
