#include "lode/models/terrain/tile_pyramid/border_chain.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lode::tile_pyramid {
namespace {

/// The part of a tile's tolerance that its sides take: with all of it, samples beside them would
/// often be beyond, and need vertices of their own.
constexpr double kSidePart = 0.5;

/// The worst place of a profile against a straight line, between nodes.
struct Worst {
  double error = 0;
  double at = 0;
};

Worst worst_between(const Profile& profile, std::uint16_t from, std::uint16_t to, double z_from,
                    double z_to) {
  Worst worst;
  const auto first = std::ranges::upper_bound(profile.at, static_cast<double>(from));
  for (auto at = first; at != profile.at.end() && *at < to; ++at) {
    const double part = (*at - from) / (to - from);
    const double z = profile.heights[static_cast<std::size_t>(at - profile.at.begin())];
    const double error = std::abs(z - (z_from + part * (z_to - z_from)));
    if (error > worst.error) worst = {error, *at};
  }
  return worst;
}

}  // namespace

double rounded(double height, double step) { return std::floor(height / step + 0.5) * step; }

std::vector<std::uint16_t> refine_chain(const Profile& profile, std::span<const std::uint16_t> kept,
                                        const LevelForm& form) {
  const double max_error = kSidePart * form.max_error;
  std::vector<std::uint16_t> chain{0};
  std::vector<std::uint16_t> ahead{kLastNode};
  for (auto node = kept.rbegin(); node != kept.rend(); ++node)
    if (*node > 0 && *node < kLastNode) ahead.push_back(*node);
  while (!ahead.empty()) {
    const std::uint16_t from = chain.back();
    const std::uint16_t to = ahead.back();
    const Worst worst =
        worst_between(profile, from, to, rounded(profile.height(from), form.height_step),
                      rounded(profile.height(to), form.height_step));
    if (worst.error > max_error && to - from > 1) {
      const double nearest = std::round(worst.at);
      ahead.push_back(static_cast<std::uint16_t>(std::clamp(nearest, from + 1.0, to - 1.0)));
      continue;
    }
    if (const std::int32_t n = (to - from + form.most_gap - 1) / form.most_gap; n > 1) {
      ahead.push_back(static_cast<std::uint16_t>(from + (to - from) * (n / 2) / n));
      continue;
    }
    chain.push_back(to);
    ahead.pop_back();
  }
  return chain;
}

BorderChains::BorderChains(const BorderLines& lines, std::span<const TileRange> ranges,
                           std::span<const LevelForm> forms, Threads threads) {
  levels_.reserve(ranges.size());
  for (const TileRange& range : ranges) {
    const auto n_wests = static_cast<std::size_t>((range.n_columns() + 1) * range.n_rows());
    const auto n_souths = static_cast<std::size_t>(range.n_columns() * (range.n_rows() + 1));
    Level level{range, std::vector<std::vector<std::uint16_t>>(n_wests),
                std::vector<std::vector<std::uint16_t>>(n_souths)};
    const LevelForm& form = forms[static_cast<std::size_t>(range.level)];
    parallel_for(n_wests + n_souths, threads, 16, [&](std::size_t i, int) {
      const bool is_west = i < n_wests;
      const auto k = static_cast<std::int64_t>(is_west ? i : i - n_wests);
      const std::int64_t n_columns = range.n_columns() + (is_west ? 1 : 0);
      const std::int64_t x = wrapped_column(range.level, range.first_x + k % n_columns);
      const TileSide side{{range.level, x, range.first_y + k / n_columns}, is_west};
      auto& chain = is_west ? level.west_sides[i] : level.south_sides[i - n_wests];
      chain = refine_chain(lines.profile(side), inherited(side), form);
    });
    levels_.push_back(std::move(level));
  }
}

std::span<const std::uint16_t> BorderChains::nodes(const TileSide& side) const {
  return *find(levels_[static_cast<std::size_t>(side.tile.level)], side);
}

const std::vector<std::uint16_t>* BorderChains::find(const Level& level, const TileSide& side) {
  const TileRange& range = level.range;
  const std::int64_t x = wrapped_column(range.level, side.tile.x - range.first_x);
  const std::int64_t y = side.tile.y - range.first_y;
  const std::int64_t n_columns = range.n_columns() + (side.is_west ? 1 : 0);
  const std::int64_t n_rows = range.n_rows() + (side.is_west ? 0 : 1);
  if (x >= n_columns || y < 0 || y >= n_rows) return nullptr;
  const auto& sides = side.is_west ? level.west_sides : level.south_sides;
  return &sides[static_cast<std::size_t>(y * n_columns + x)];
}

std::vector<std::uint16_t> BorderChains::inherited(const TileSide& side) const {
  const TileId& tile = side.tile;
  const std::int64_t across = side.is_west ? tile.x : tile.y;
  if (tile.level == 0 || across % 2 != 0) return {};
  const auto* parent =
      find(levels_.back(), {{tile.level - 1, tile.x >> 1, tile.y >> 1}, side.is_west});
  if (parent == nullptr) return {};
  const std::int64_t half = side.is_west ? tile.y % 2 : tile.x % 2;
  std::vector<std::uint16_t> kept;
  for (const std::uint16_t node : *parent) {
    const std::int64_t at = 2 * std::int64_t{node} - half * kLastNode;
    if (at >= 0 && at <= kLastNode) kept.push_back(static_cast<std::uint16_t>(at));
  }
  return kept;
}

}  // namespace lode::tile_pyramid
