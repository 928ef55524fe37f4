#include "lode/io/resampling_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lode/core/parallel_check.h"
#include "lode/io/vector_input.h"

namespace lode::io {
namespace {

/// The sum of squares beside what is told.
struct StripError {
  ResamplingError error;
  double squares = 0;
};

/// Between the four heights round a place in columns and rows; NaN where one is missing.
double bilinear(const HeightGrid& grid, double column, double row) {
  const auto x =
      static_cast<std::int32_t>(std::clamp(std::floor(column), 0.0, grid.n_columns - 2.0));
  const auto y = static_cast<std::int32_t>(std::clamp(std::floor(row), 0.0, grid.n_rows - 2.0));
  const double u = column - x;
  const double v = row - y;
  constexpr double kRounding = 1e-6;  // of steps that were told from places
  if (u < -kRounding || v < -kRounding || u > 1 + kRounding || v > 1 + kRounding) return NAN;
  for (const std::int32_t dy : {0, 1})
    for (const std::int32_t dx : {0, 1})
      if (!grid.has_height(x + dx, y + dy)) return NAN;
  const auto along = [&](std::int32_t at) {
    return (1 - u) * grid.height(x, at) + u * grid.height(x + 1, at);
  };
  return (1 - v) * along(y) + v * along(y + 1);
}

Result<void> measure_rows(const HeightGrid& file, const HeightGrid& resampled,
                          const PlaceTransform& to_resampled, std::int32_t begin, std::int32_t end,
                          StripError& strip) {
  const auto n = static_cast<std::size_t>(file.n_columns);
  std::vector<Vec<double, 2>> places(n);
  const double middle = resampled.world(0.5 * resampled.n_columns, 0.5 * resampled.n_rows)[0];
  for (std::int32_t y = begin; y < end; ++y) {
    for (std::size_t x = 0; x < n; ++x) places[x] = file.world(static_cast<double>(x), y);
    LODE_CHECK(to_resampled.apply<2>(places));
    // Longitudes go on beyond 180 degrees where the raster does.
    for (auto& place : places) place[0] = middle + std::remainder(place[0] - middle, 360.0);
    for (std::size_t x = 0; x < n; ++x) {
      const auto column = static_cast<std::int32_t>(x);
      if (!file.has_height(column, y)) continue;
      const auto at = resampled.lattice(places[x][0], places[x][1]);
      const double off = std::abs(file.height(column, y) - bilinear(resampled, at[0], at[1]));
      if (std::isnan(off)) {
        ++strip.error.n_outside;
        continue;
      }
      ++strip.error.n_measured;
      strip.error.largest = std::max(strip.error.largest, off);
      strip.squares += off * off;
    }
  }
  return {};
}

}  // namespace

Result<ResamplingError> measure_resampling(const std::string& path,
                                           const HeightReadOptions& options, Threads threads,
                                           Progress& progress) {
  HeightReadOptions as_they_are = options;
  as_they_are.vertical = {};  // of both alike
  LODE_TRY(const HeightRaster resampled, read_heights(path, as_they_are, progress));
  as_they_are.to_degrees.reset();
  LODE_TRY(const HeightRaster file, read_heights(path, as_they_are, progress));
  if (resampled.grid.n_columns < 2 || resampled.grid.n_rows < 2)
    return ResamplingError{.n_outside = static_cast<std::uint64_t>(file.grid.n_samples()) -
                                        file.grid.n_missing()};
  constexpr std::int32_t kRows = 64;
  const auto n_strips = static_cast<std::size_t>((file.grid.n_rows + kRows - 1) / kRows);
  std::vector<StripError> strips(n_strips);
  LODE_CHECK(check_all(n_strips, threads, [&](std::size_t i) -> Result<void> {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const PlaceTransform to_resampled,
             PlaceTransform::make(path, file.grid.crs, resampled.grid.crs, "resampled raster"));
    const auto begin = static_cast<std::int32_t>(i) * kRows;
    return measure_rows(file.grid, resampled.grid, to_resampled, begin,
                        std::min(begin + kRows, file.grid.n_rows), strips[i]);
  }));
  ResamplingError all;
  double squares = 0;
  for (const StripError& strip : strips) {
    all.n_measured += strip.error.n_measured;
    all.n_outside += strip.error.n_outside;
    all.largest = std::max(all.largest, strip.error.largest);
    squares += strip.squares;
  }
  if (all.n_measured > 0) all.rms = std::sqrt(squares / static_cast<double>(all.n_measured));
  return all;
}

}  // namespace lode::io
