#include "lode/mappers/surface_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "lode/core/expects.h"

namespace lode {
namespace {

template <std::size_t N>
using Corners = std::array<Vec3d, N>;

/// Which way round the corners of two cells are the same, if any.
enum class Sense : std::uint8_t { none, same, turned };

bool is_near(const Vec3d& a, const Vec3d& b, double distance) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!(std::abs(a[i] - b[i]) <= distance)) return false;
  return true;
}

template <std::size_t N>
Sense compare(const Corners<N>& a, const Corners<N>& b, double distance) {
  // The two ends of a line are in order in one way only.
  constexpr std::size_t kRotations = N == 2 ? 1 : N;
  for (const Sense sense : {Sense::same, Sense::turned})
    for (std::size_t first = 0; first < kRotations; ++first) {
      bool is_equal = true;
      for (std::size_t k = 0; k < N && is_equal; ++k) {
        const std::size_t j = (first + k) % N;
        is_equal = is_near(a[k], b[sense == Sense::same ? j : N - 1 - j], distance);
      }
      if (is_equal) return sense;
    }
  return Sense::none;
}

/// The cells that no pair in the same place of both lists accounts for are looked up by the cube of
/// a regular grid that their centre lies in.
template <std::size_t N>
class Matcher {
 public:
  using Cells = std::vector<std::array<std::uint32_t, N>>;

  Matcher(const Surface& expected, const Cells& expected_cells, const Surface& surface,
          const Cells& cells, double distance)
      : expected_(expected),
        expected_cells_(expected_cells),
        surface_(surface),
        cells_(cells),
        distance_(distance),
        cube_(4 * distance) {}

  MatchReport run() {
    report_.n_cells = cells_.size();
    pair_in_order();
    for (const std::uint32_t i : open_expected_) by_cube_.emplace(cube_of(centre(expected(i))), i);
    for (const std::uint32_t i : open_) find_partner(i);
    for (const auto& [cube, i] : by_cube_) {
      if (report_.n_missing++ == 0) report_.first_missing = i;
      report_.first_missing = std::min(report_.first_missing, i);
    }
    return report_;
  }

 private:
  using Cube = std::uint64_t;

  void pair_in_order() {
    const std::size_t n = std::max(cells_.size(), expected_cells_.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      const bool is_in_both = i < std::min(cells_.size(), expected_cells_.size());
      if (is_in_both && compare<N>(expected(i), found(i), distance_) == Sense::same) continue;
      if (i < cells_.size()) open_.push_back(i);
      if (i < expected_cells_.size()) open_expected_.push_back(i);
    }
  }

  /// The nearest of those turned the same way, else of those turned the other; then the first.
  void find_partner(std::uint32_t i) {
    const Corners<N> corners = found(i);
    const Vec3d middle = centre(corners);
    auto best = by_cube_.end();
    std::tuple<bool, double, std::uint32_t> best_rank;
    for (int side = 0; side < 8; ++side) {
      Vec3d near = middle;
      for (std::size_t k = 0; k < 3; ++k)
        near[k] += ((side >> k) & 1) != 0 ? distance_ : -distance_;
      const auto [begin, end] = by_cube_.equal_range(cube_of(near));
      for (auto at = begin; at != end; ++at) {
        const Corners<N> candidate = expected(at->second);
        const Sense sense = compare<N>(candidate, corners, distance_);
        if (sense == Sense::none) continue;
        const Vec3d offset = centre(candidate) - middle;
        const std::tuple rank{sense == Sense::turned, dot(offset, offset), at->second};
        if (best != by_cube_.end() && !(rank < best_rank)) continue;
        best = at;
        best_rank = rank;
      }
    }
    if (best == by_cube_.end()) {
      if (report_.n_extra++ == 0) report_.first_extra = i;
      return;
    }
    if (std::get<0>(best_rank) && report_.n_turned++ == 0) report_.first_turned = i;
    by_cube_.erase(best);
  }

  /// Cubes that share a number cost time only.
  [[nodiscard]] Cube cube_of(const Vec3d& p) const {
    Cube cube = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto step = static_cast<std::int64_t>(std::floor(p[k] / cube_));
      cube = (cube ^ static_cast<Cube>(step)) * 0x9e3779b97f4a7c15U;
    }
    return cube;
  }

  [[nodiscard]] static Vec3d centre(const Corners<N>& corners) {
    Vec3d sum;
    for (const Vec3d& p : corners) sum = sum + p;
    return (1.0 / N) * sum;
  }

  [[nodiscard]] static Corners<N> corners_of(const Surface& surface,
                                             const std::array<std::uint32_t, N>& cell) {
    Corners<N> corners;
    for (std::size_t k = 0; k < N; ++k) corners[k] = surface.world_position(cell[k]);
    return corners;
  }
  [[nodiscard]] Corners<N> expected(std::uint32_t i) const {
    return corners_of(expected_, expected_cells_[i]);
  }
  [[nodiscard]] Corners<N> found(std::uint32_t i) const { return corners_of(surface_, cells_[i]); }

  const Surface& expected_;
  const Cells& expected_cells_;
  const Surface& surface_;
  const Cells& cells_;
  double distance_;
  double cube_;  ///< Side, world units.
  std::vector<std::uint32_t> open_, open_expected_;
  std::unordered_multimap<Cube, std::uint32_t> by_cube_;
  MatchReport report_;
};

}  // namespace

MatchReport match_surfaces(const Surface& expected, const Surface& surface, double distance) {
  LODE_EXPECTS(distance > 0 || (expected.is_empty() && surface.is_empty()));
  if (expected.lines.empty() && surface.lines.empty())
    return Matcher<3>(expected, expected.triangles, surface, surface.triangles, distance).run();
  return Matcher<2>(expected, expected.lines, surface, surface.lines, distance).run();
}

}  // namespace lode
