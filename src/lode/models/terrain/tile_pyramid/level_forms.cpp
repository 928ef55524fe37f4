#include "lode/models/terrain/tile_pyramid/level_forms.h"

#include <algorithm>
#include <cmath>

#include "lode/models/terrain/tile_pyramid/build.h"
#include "lode/models/terrain/tile_pyramid/globe_lattice.h"

namespace lode::tile_pyramid {
namespace {

HeightRange join(HeightRange a, HeightRange b) {
  if (a.lower > a.upper) return b;
  if (b.lower > b.upper) return a;
  return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
}

/// By tile of a range, in rows.
using Ranges = std::vector<HeightRange>;

constexpr double kMostSamples = 256;

Ranges ranges_of(const BorderLines& lines, const TileRange& finest) {
  Ranges ranges;
  for (std::int64_t y = finest.first_y; y <= finest.last_y; ++y)
    for (std::int64_t x = finest.first_x; x <= finest.last_x; ++x)
      ranges.push_back(lines.range(x, y));
  return ranges;
}

/// Those of the four tiles in each, and the fill where one is not there.
Ranges coarser(const Ranges& ranges, const TileRange& finer, const TileRange& range,
               HeightRange fill) {
  Ranges joint;
  for (std::int64_t y = range.first_y; y <= range.last_y; ++y)
    for (std::int64_t x = range.first_x; x <= range.last_x; ++x) {
      HeightRange all;
      for (const std::int64_t child_y : {2 * y, 2 * y + 1})
        for (const std::int64_t child_x : {2 * x, 2 * x + 1}) {
          const std::int64_t column = wrapped_column(finer.level, child_x - finer.first_x);
          const std::int64_t row = child_y - finer.first_y;
          all = join(all, finer.holds(child_x, child_y)
                              ? ranges[static_cast<std::size_t>(row * finer.n_columns() + column)]
                              : fill);
        }
      joint.push_back(all);
    }
  return joint;
}

double step_for(double max_error, const Ranges& ranges, HeightRange fill) {
  // Rounding may add a step.
  constexpr double kMostSteps = kLastNode - 2;
  constexpr double kMostNumber = 1 << 23;
  constexpr double kLeastStep = 1.0 / (1 << 30);
  double step = std::exp2(std::floor(std::log2(std::max(max_error / 8, kLeastStep))));
  for (HeightRange range : ranges) {
    range = join(range, fill);
    const double largest = std::max(std::abs(range.lower), std::abs(range.upper));
    while ((range.upper - range.lower) / step > kMostSteps || largest / step > kMostNumber)
      step *= 2;
  }
  return step;
}

}  // namespace

int finest_level(const ExtendedRaster& raster) {
  int level = 0;
  while (level < kMaxLevel && tile_size(level) > kMostSamples * raster.spacing()) ++level;
  return level;
}

Result<void> check_number_of_tiles(std::span<const TileRange> ranges) {
  std::uint64_t n = 0;
  for (const TileRange& range : ranges) n += range.n_tiles();
  if (n <= kMostTiles) return {};
  return fail(
      "expected at most {} tiles without --max-level, got {} down to level {}, the first whose "
      "tiles have at most {} samples a side",
      kMostTiles, n, ranges.back().level, kMostSamples);
}

std::vector<double> level_errors(double max_error, int last) {
  std::vector<double> errors;
  for (int level = 0; level <= last; ++level)
    errors.push_back(
        std::min(std::ldexp(kLevelZeroError, -level), std::ldexp(max_error, last - level)));
  return errors;
}

std::vector<LevelForm> level_forms(const BorderLines& lines, std::span<const TileRange> ranges,
                                   double fill, double max_error) {
  const HeightRange outside{fill, fill};
  const std::vector<double> errors = level_errors(max_error, ranges.back().level);
  std::vector<LevelForm> forms(ranges.size());
  Ranges heights = ranges_of(lines, ranges.back());
  for (std::size_t level = ranges.size(); level-- > 0;) {
    forms[level] = {.max_error = errors[level],
                    .height_step = step_for(errors[level], heights, outside),
                    .most_gap = most_gap(static_cast<int>(level))};
    if (level > 0) heights = coarser(heights, ranges[level], ranges[level - 1], outside);
  }
  return forms;
}

}  // namespace lode::tile_pyramid
