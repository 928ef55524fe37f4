#include "lode/models/tetra_mt/node_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lode::tetra_mt {
namespace {

constexpr int kCurveBits = 21;  ///< Of each coordinate.

/// 21 bits, two zeros before each.
std::uint64_t spaced(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001F00000000FFFFU;
  bits = (bits | bits << 16) & 0x001F0000FF0000FFU;
  bits = (bits | bits << 8) & 0x100F00F00F00F00FU;
  bits = (bits | bits << 4) & 0x10C30C30C30C30C3U;
  return (bits | bits << 2) & 0x1249249249249249U;
}

/// Places on a Morton curve through a cube round all positions.
class Curve {
 public:
  explicit Curve(std::span<const Vec3d> positions) {
    double width = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto by_axis = [i](const Vec3d& p) { return p[i]; };
      if (positions.empty()) break;
      lower_[i] = std::ranges::min(positions, {}, by_axis)[i];
      width = std::max(width, std::ranges::max(positions, {}, by_axis)[i] - lower_[i]);
    }
    scale_ = width > 0 ? kSteps / width : 0;
    if (!std::isfinite(scale_)) scale_ = 0;
  }
  [[nodiscard]] std::uint64_t operator()(const Vec3d& p) const {
    std::uint64_t key = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double step = std::clamp((p[i] - lower_[i]) * scale_, 0.0, kSteps - 1);
      key |= spaced(static_cast<std::uint64_t>(step)) << i;
    }
    return key;
  }

 private:
  static constexpr double kSteps = 1 << kCurveBits;
  Vec3d lower_;
  double scale_ = 0;
};

/// Of the node that comes at a place in the order of refinement.
std::uint32_t band_of(std::size_t place, std::size_t n_nodes) {
  constexpr std::size_t kGrowth = 8;
  constexpr std::size_t kSmallest = 1024;
  std::uint32_t band = 0;
  for (std::size_t end = n_nodes; end > kSmallest && place < end / kGrowth; end /= kGrowth) ++band;
  return band;
}

}  // namespace

NodeOrder order_nodes(const TetraMesh& mesh, std::span<const Collapse> collapses) {
  const Curve curve(mesh.positions);
  std::vector<std::uint8_t> is_base(mesh.positions.size(), 0);
  for (const auto& t : mesh.tetrahedra)
    for (const std::uint32_t v : t) is_base[v] = 1;
  for (const Collapse& c : collapses) is_base[c.removed] = 0;
  struct Keyed {
    std::uint32_t band;
    std::uint64_t key;
    std::uint32_t index;
    auto operator<=>(const Keyed&) const = default;
  };
  std::vector<Keyed> keyed;
  for (std::uint32_t v = 0; v < is_base.size(); ++v)
    if (is_base[v] != 0) keyed.push_back({0, curve(mesh.positions[v]), v});
  std::ranges::sort(keyed);
  NodeOrder order;
  for (const Keyed& k : keyed) order.base_vertices.push_back(k.index);

  keyed.clear();
  const std::size_t n = collapses.size();
  for (std::size_t i = 0; i < n; ++i)
    keyed.push_back({~band_of(n - 1 - i, n), curve(mesh.positions[collapses[i].removed]),
                     static_cast<std::uint32_t>(i)});
  std::ranges::sort(keyed);
  order.nodes.resize(n);
  for (std::uint32_t node = 0; node < n; ++node) order.nodes[keyed[node].index] = node;
  return order;
}

}  // namespace lode::tetra_mt
