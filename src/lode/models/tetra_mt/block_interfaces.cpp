// What a collapse does to the boundary and to faces between regions.
#include <cmath>

#include "lode/models/tetra_mt/block_collapser.h"

namespace lode::tetra_mt {
namespace {

/// How far from the faces' planes a vertex may be that goes along them, against its distance.
constexpr double kCoplanar = 1e-6;

}  // namespace

void BlockCollapser::find_interfaces_of(const Star& star, Interfaces& found) const {
  if (state_.labels.empty()) {
    find_boundary(star, found);
    return;
  }
  std::array<std::uint32_t, Star::kMaxTriangles> labels;
  const auto n = static_cast<std::size_t>(star.n_triangles);
  for (std::size_t i = 0; i < n; ++i) labels[i] = state_.labels[slots_[star.slots[i]]];
  find_interfaces(star, std::span(labels).first(n), found);
}

/// The new faces lie in the planes of the old ones: with each of these the vertex that is kept
/// makes no volume. So every region keeps its own.
bool BlockCollapser::stays_in_place(int kept) const {
  if (!goes_along(interfaces_, kept)) return false;
  const Vec3d& at = link_[static_cast<std::size_t>(kept)];
  for (int i = 0; i < interfaces_.n_faces; ++i) {
    const auto& edge = interfaces_.faces[static_cast<std::size_t>(i)].edge;
    if (edge[0] == kept || edge[1] == kept) continue;
    const Vec3d normal = cross(link_[edge[0]], link_[edge[1]]);
    if (!(std::abs(dot(normal, at)) <= kCoplanar * length(normal) * length(at))) return false;
  }
  return true;
}

/// Expects the link condition of the mesh.
bool BlockCollapser::keeps_regions(int kept) {
  if (state_.labels.empty() || interfaces_.kind == Interfaces::Kind::none) return true;
  if (!gatherer_.gather(star_.link[static_cast<std::size_t>(kept)], other_)) return false;
  find_interfaces_of(other_, other_interfaces_);
  return keeps_interfaces(star_, interfaces_, kept, other_, other_interfaces_);
}

}  // namespace lode::tetra_mt
