#include "lode/models/terrain/tile_pyramid/border_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::tile_pyramid {
namespace {

constexpr std::int64_t kMargin = ExtendedRaster::kMargin;

void join(HeightRange& range, double z) {
  const bool is_empty = range.lower > range.upper;
  range = is_empty ? HeightRange{z, z}
                   : HeightRange{std::min(range.lower, z), std::max(range.upper, z)};
}

}  // namespace

double Profile::height(double node) const {
  const auto after = std::upper_bound(at.begin(), at.end(), node);
  if (after == at.begin()) return heights.front();
  const auto i = static_cast<std::size_t>(after - at.begin()) - 1;
  if (after == at.end() || at[i] == node) return heights[i];
  const double part = (node - at[i]) / (at[i + 1] - at[i]);
  return heights[i] + part * (heights[i + 1] - heights[i]);
}

BorderLines::BorderLines(const ExtendedRaster& raster, const TileRange& finest)
    : raster_(raster),
      finest_(finest),
      meridians_(static_cast<std::size_t>(finest.n_columns() + 1)),
      parallels_(static_cast<std::size_t>(finest.n_rows() + 1)),
      ranges_(finest.n_tiles()) {
  for (std::size_t line = 0; line < meridians_.size(); ++line) {
    const std::int64_t x =
        wrapped_column(finest.level, finest.first_x + static_cast<std::int64_t>(line));
    if (raster.column_at(west_of({finest.level, x, 0})))
      meridians_[line].resize(static_cast<std::size_t>(raster.n_rows()), raster.fill());
  }
  for (std::size_t line = 0; line < parallels_.size(); ++line) {
    const std::int64_t y = finest.first_y + static_cast<std::int64_t>(line);
    if (raster.row_at(south_of({finest.level, 0, y})))
      parallels_[line].resize(static_cast<std::size_t>(raster.n_columns()), raster.fill());
  }
}

Result<BorderLines> BorderLines::scan(HeightRows& rows, const ExtendedRaster& raster,
                                      const TileRange& finest, Threads threads,
                                      Progress& progress) {
  BorderLines lines(raster, finest);
  RowStrip strip(raster);
  for (std::int64_t first = 0; first < raster.n_rows(); first += kStripRows) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("borders", static_cast<double>(first) / static_cast<double>(raster.n_rows()));
    const IndexRange own{first, std::min(first + kStripRows, raster.n_rows()) - 1};
    LODE_CHECK(strip.read(rows, {own.first, own.last + 1}));
    const std::size_t n_meridians = lines.meridians_.size();
    const std::size_t n_lines = n_meridians + lines.parallels_.size();
    parallel_for(n_lines + lines.ranges_.size(), threads, 1, [&](std::size_t i, int) {
      if (i < n_meridians)
        lines.add_meridian(i, strip, own);
      else if (i < n_lines)
        lines.add_parallel(i - n_meridians, strip, own);
      else
        lines.add_range(i - n_lines, strip, own);
    });
  }
  return lines;
}

void BorderLines::add_meridian(std::size_t line, const RowStrip& strip, IndexRange rows) {
  if (meridians_[line].empty()) return;
  const std::int64_t x =
      wrapped_column(finest_.level, finest_.first_x + static_cast<std::int64_t>(line));
  const auto column = raster_.column_at(west_of({finest_.level, x, 0}));
  for (std::int64_t row = rows.first; row <= rows.last; ++row)
    meridians_[line][static_cast<std::size_t>(row)] =
        column->mix(strip.height(column->first, row), strip.height(column->first + 1, row));
}

void BorderLines::add_parallel(std::size_t line, const RowStrip& strip, IndexRange rows) {
  if (parallels_[line].empty()) return;
  const std::int64_t y = finest_.first_y + static_cast<std::int64_t>(line);
  const auto row = raster_.row_at(south_of({finest_.level, 0, y}));
  const std::int64_t stored = std::clamp<std::int64_t>(row->first, 0, raster_.n_rows() - 1);
  if (stored < rows.first || stored > rows.last) return;
  for (std::int64_t column = 0; column < raster_.n_columns(); ++column)
    parallels_[line][static_cast<std::size_t>(column)] =
        row->mix(strip.height(column, row->first), strip.height(column, row->first + 1));
}

void BorderLines::add_range(std::size_t tile, const RowStrip& strip, IndexRange rows) {
  const auto n_columns = static_cast<std::size_t>(finest_.n_columns());
  const double size = tile_size(finest_.level);
  const auto x =
      wrapped_column(finest_.level, finest_.first_x + static_cast<std::int64_t>(tile % n_columns));
  const auto y = finest_.first_y + static_cast<std::int64_t>(tile / n_columns);
  const double west = west_of({finest_.level, x, 0});
  const double south = south_of({finest_.level, 0, y});
  const IndexRange all = raster_.rows_between(south, south + size, -kMargin, 1);
  HeightRange& range = ranges_[tile];
  if (all.first < -1 || all.last > raster_.n_rows()) join(range, raster_.fill());
  const IndexRange held{std::max(all.first, rows.first), std::min(all.last, rows.last)};
  if (held.is_empty()) return;
  for (int turn = ExtendedRaster::kFirstTurn; turn <= ExtendedRaster::kLastTurn; ++turn) {
    const IndexRange columns = raster_.columns_between(west, west + size, turn, -kMargin, 1);
    for (std::int64_t row = held.first; row <= held.last; ++row)
      for (std::int64_t column = columns.first; column <= columns.last; ++column)
        join(range, strip.height(column, row));
  }
}

Profile BorderLines::profile(const TileSide& side) const {
  Profile profile = side.is_west ? along_meridian(side) : along_parallel(side);
  if (profile.at.empty()) profile = {{0}, {raster_.fill()}};
  return profile;
}

Profile BorderLines::along_meridian(const TileSide& side) const {
  const int finer = finest_.level - side.tile.level;
  const std::int64_t line = wrapped_column(finest_.level, (side.tile.x << finer) - finest_.first_x);
  Profile profile;
  if (line >= static_cast<std::int64_t>(meridians_.size())) return profile;
  const std::vector<double>& heights = meridians_[static_cast<std::size_t>(line)];
  if (heights.empty()) return profile;
  const double size = tile_size(side.tile.level);
  const double south = south_of(side.tile);
  const IndexRange rows = raster_.rows_between(south, south + size, -kMargin, 1);
  for (std::int64_t row = rows.first; row <= rows.last; ++row) {
    const bool is_fill = row < -1 || row > raster_.n_rows();
    const auto stored =
        static_cast<std::size_t>(std::clamp<std::int64_t>(row, 0, raster_.n_rows() - 1));
    profile.at.push_back((raster_.latitude(static_cast<double>(row)) - south) / size * kLastNode);
    profile.heights.push_back(is_fill ? raster_.fill() : heights[stored]);
  }
  if (profile.at.size() > 1 && profile.at[0] > profile.at[1]) {
    std::ranges::reverse(profile.at);
    std::ranges::reverse(profile.heights);
  }
  return profile;
}

Profile BorderLines::along_parallel(const TileSide& side) const {
  const int finer = finest_.level - side.tile.level;
  const std::int64_t line = (side.tile.y << finer) - finest_.first_y;
  if (line < 0 || line >= static_cast<std::int64_t>(parallels_.size())) return {};
  const std::vector<double>& heights = parallels_[static_cast<std::size_t>(line)];
  if (heights.empty()) return {};
  const double size = tile_size(side.tile.level);
  const double west = west_of(side.tile);
  std::vector<std::pair<double, double>> places;
  for (int turn = ExtendedRaster::kFirstTurn; turn <= ExtendedRaster::kLastTurn; ++turn) {
    const IndexRange columns = raster_.columns_between(west, west + size, turn, -kMargin, 1);
    for (std::int64_t column = columns.first; column <= columns.last; ++column) {
      const std::int64_t n = raster_.n_columns();
      const bool is_fill = !raster_.wraps() && (column < -1 || column > n);
      const std::int64_t stored =
          raster_.wraps() ? (column + n) % n : std::clamp<std::int64_t>(column, 0, n - 1);
      places.emplace_back(
          (raster_.longitude(static_cast<double>(column), turn) - west) / size * kLastNode,
          is_fill ? raster_.fill() : heights[static_cast<std::size_t>(stored)]);
    }
  }
  std::ranges::sort(places);
  Profile profile;
  for (const auto& [at, z] : places) {
    // The same sample, in the turn before.
    constexpr double kSame = 1e-6;
    if (!profile.at.empty() && at - profile.at.back() < kSame) continue;
    profile.at.push_back(at);
    profile.heights.push_back(z);
  }
  return profile;
}

}  // namespace lode::tile_pyramid
