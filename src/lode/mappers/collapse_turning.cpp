#include "lode/mappers/collapse_turning.h"

#include <array>
#include <cstddef>
#include <utility>

#include "lode/core/disjoint_sets.h"

namespace lode::simplification {
namespace {

/// Six times the volumes that triangles enclose, by component. Of places relative to the
/// component's first vertex, which floats are exactly enough.
class Volumes {
 public:
  explicit Volumes(std::size_t n) : volumes_(n), origins_(n), has_origin_(n) {}

  void add(std::uint32_t component, const std::array<Vec3f, 3>& corners) {
    if (has_origin_[component] == 0) {
      has_origin_[component] = 1;
      origins_[component] = widened(corners[0]);
    }
    const Vec3d& o = origins_[component];
    volumes_[component] +=
        dot(widened(corners[0]) - o, cross(widened(corners[1]) - o, widened(corners[2]) - o));
  }
  [[nodiscard]] std::vector<double> take() { return std::move(volumes_); }

 private:
  std::vector<double> volumes_;
  std::vector<Vec3d> origins_;
  std::vector<std::uint8_t> has_origin_;
};

}  // namespace

ClosedComponents::ClosedComponents(const Surface& surface) : component_(surface.positions.size()) {
  DisjointSets<> sets(surface.positions.size());
  std::vector<std::uint32_t> ends(surface.positions.size(), 0);
  for (const auto& [a, b, c] : surface.triangles) {
    sets.join(a, b);
    sets.join(b, c);
    // Round a vertex inside each neighbour comes twice.
    ends[a] ^= b ^ c;
    ends[b] ^= c ^ a;
    ends[c] ^= a ^ b;
  }
  std::uint32_t n = 0;
  for (std::uint32_t v = 0; v < component_.size(); ++v) {
    const std::uint32_t root = sets.find(v);  // the first of the set
    component_[v] = root == v ? n++ : component_[root];
  }
  Volumes volumes(n);
  for (const auto& [a, b, c] : surface.triangles)
    volumes.add(component_[a], {surface.positions[a], surface.positions[b], surface.positions[c]});
  volumes_ = volumes.take();
  for (std::uint32_t v = 0; v < component_.size(); ++v)
    if (ends[v] != 0) volumes_[component_[v]] = 0;
}

std::vector<std::uint32_t> ClosedComponents::removed_where_turned(
    const CollapseMesh& mesh, std::span<const std::uint32_t> live) const {
  Volumes volumes(volumes_.size());
  for (const std::uint32_t t : live)
    volumes.add(component_[mesh.triangles[t].v[0]], corners(mesh, t));
  const std::vector<double> now = volumes.take();
  const auto is_turned = [&](std::uint32_t component) {
    return (volumes_[component] > 0 && !(now[component] > 0)) ||
           (volumes_[component] < 0 && !(now[component] < 0));
  };
  std::vector<std::uint32_t> removed;
  for (std::uint32_t v = 0; v < component_.size(); ++v)
    if (is_turned(component_[v]) && mesh.is_removed(v)) removed.push_back(v);
  return removed;
}

}  // namespace lode::simplification
