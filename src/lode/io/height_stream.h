#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "lode/core/result.h"
#include "lode/io/height_reader.h"

namespace lode::io {

/// A raster of heights that stays in its file, for those larger than memory. To be used, and
/// destroyed, by the thread that opened it.
class HeightStream {
 public:
  /// As read_heights(), but of files that GDAL reads only: fails on others. Heights that have a
  /// target are transformed as they are read.
  [[nodiscard]] static Result<HeightStream> open(const std::string& path,
                                                 const HeightReadOptions& options,
                                                 Progress& progress);

  /// The same file, with other options of what its heights are above; it is not opened again.
  [[nodiscard]] Result<HeightStream> with_vertical(const VerticalOptions& vertical,
                                                   Progress& progress) &&;

  HeightStream(HeightStream&&) noexcept;
  HeightStream& operator=(HeightStream&&) = delete;
  ~HeightStream();

  /// Without samples.
  [[nodiscard]] const HeightRaster& raster() const;
  /// Bytes of all samples in memory, as read_heights() has them.
  [[nodiscard]] std::uint64_t n_bytes() const;
  /// Fills `out` with whole rows; NaN where a sample is missing.
  [[nodiscard]] Result<void> read(std::int32_t first, std::int32_t n_rows,
                                  std::span<double> out) const;

 private:
  struct Impl;
  explicit HeightStream(std::unique_ptr<Impl> impl);
  [[nodiscard]] static Result<HeightStream> of(std::unique_ptr<Impl> impl, Progress& progress);

  std::unique_ptr<Impl> impl_;
};

/// Heights of some rows of a grid; NaN where one is missing.
void copy_rows(const HeightGrid& grid, std::int32_t first, std::int32_t n_rows,
               std::span<double> out);

}  // namespace lode::io
