#include "lode/models/tetra_mt/space_blocks.h"

#include <algorithm>
#include <utility>

namespace lode::tetra_mt {
namespace {

class Cutter {
 public:
  Cutter(std::span<const Vec3d> positions, std::size_t max_size)
      : positions_(positions), max_size_(max_size) {}

  void cut(std::span<std::uint32_t> points, double share, int depth,
           std::vector<std::size_t>& sizes) const {
    if (points.size() <= max_size_) {
      std::sort(points.begin(), points.end());
      sizes.push_back(points.size());
      return;
    }
    const std::size_t axis = longest_side(points);
    const auto n = static_cast<std::size_t>(share * static_cast<double>(points.size()));
    const auto middle = points.begin() + static_cast<std::ptrdiff_t>(
                                             std::clamp<std::size_t>(n, 1, points.size() - 1));
    std::nth_element(points.begin(), middle, points.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(positions_[a][axis], a) < std::pair(positions_[b][axis], b);
    });
    const auto below = static_cast<std::size_t>(middle - points.begin());
    const double next = depth < 2 ? share : 0.5;
    cut(points.first(below), next, depth + 1, sizes);
    cut(points.subspan(below), next, depth + 1, sizes);
  }

 private:
  [[nodiscard]] std::size_t longest_side(std::span<const std::uint32_t> points) const {
    Vec3d lower = positions_[points[0]];
    Vec3d upper = lower;
    for (const std::uint32_t p : points)
      for (std::size_t i = 0; i < 3; ++i) {
        lower[i] = std::min(lower[i], positions_[p][i]);
        upper[i] = std::max(upper[i], positions_[p][i]);
      }
    const Vec3d sides = upper - lower;
    return static_cast<std::size_t>(std::ranges::max_element(sides.v) - sides.v.begin());
  }

  std::span<const Vec3d> positions_;
  std::size_t max_size_;
};

}  // namespace

SpaceBlocks cut_in_blocks(std::span<const Vec3d> positions, std::vector<std::uint32_t> points,
                          std::size_t max_size, double share) {
  SpaceBlocks blocks;
  blocks.points = std::move(points);
  std::vector<std::size_t> sizes;
  if (!blocks.points.empty()) Cutter(positions, max_size).cut(blocks.points, share, 0, sizes);
  blocks.begins.push_back(0);
  for (const std::size_t size : sizes) blocks.begins.push_back(blocks.begins.back() + size);
  return blocks;
}

}  // namespace lode::tetra_mt
