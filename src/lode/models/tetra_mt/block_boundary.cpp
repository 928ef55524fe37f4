// How far the boundary is from the reference's, measured at the vertices that went, where it may
// move.
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <vector>

#include "lode/models/tetra_mt/block_collapser.h"
#include "lode/models/tetra_mt/patch_deviation.h"

namespace lode::tetra_mt {

/// Nothing where the boundary stays, or the vertex is not on it alone.
void BlockCollapser::gather_boundary() {
  on_boundary_.clear();
  boundary_points_.clear();
  if (state_.first_on_boundary.empty() || !star_.is_on_boundary()) return;
  on_boundary_.push_back(global(star_.vertex));
  for (int i = 0; i < star_.n_triangles; ++i) {
    if (!star_.has(i, star_.outside)) continue;
    const std::uint32_t slot = slots_[star_.slots[static_cast<std::size_t>(i)]];
    for (std::uint32_t v = state_.first_on_boundary[slot]; v != kNone;
         v = state_.next_on_boundary[v])
      on_boundary_.push_back(v);
  }
  if (interfaces_.kind != Interfaces::Kind::sheet) return;
  for (const std::uint32_t v : on_boundary_)
    boundary_points_.push_back((state_.mesh.positions[v] - positions_[star_.vertex]) * scale_);
}

/// Of vertices that went, from the nearest of the faces to come, and in the star's unit. Between
/// two of them the reference is straight, and a face that comes bends along its edges: by no more
/// than a quarter of the way between them, times what it turns by, do they part there.
double BlockCollapser::measured_of(int kept, double limit) const {
  const Vec3d& at = link_[static_cast<std::size_t>(kept)];
  std::vector<std::array<Vec3d, 3>> faces;
  std::vector<Vec3d> normals;
  const InterfaceWalk ring =
      walk(interfaces_, kept, std::countr_zero(interfaces_.beside[static_cast<std::size_t>(kept)]));
  double turns = 0;
  for (std::size_t i = 1; i + 1 < static_cast<std::size_t>(ring.n); ++i) {
    faces.push_back({at, link_[ring.places[i]], link_[ring.places[i + 1]]});
    const Vec3d normal = cross(faces.back()[1] - at, faces.back()[2] - at);
    normals.push_back(normal * (1 / length(normal)));
    if (i > 1) turns += length(normals[i - 1] - normals[i - 2]);
  }
  double longest = 0;
  for (const std::uint32_t v : on_boundary_)
    longest = std::max(longest, static_cast<double>(state_.boundary_edges[v]));
  const double between = turns * longest * scale_ / 4;
  double farthest = 0;
  for (const Vec3d& p : boundary_points_) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& face : faces)
      if (nearest > farthest) nearest = std::min(nearest, distance_to_triangle(p, face));
    farthest = std::max(farthest, nearest);
    if (!(farthest + between <= limit)) return std::numeric_limits<double>::infinity();
  }
  return farthest + between;
}

/// Those of faces that come are the ones nearest to them.
void BlockCollapser::move_boundary(int kept) {
  if (on_boundary_.empty()) return;
  std::vector<std::uint32_t> slots;
  std::vector<std::array<Vec3d, 3>> faces;
  for (int i = 0; i < star_.n_triangles; ++i) {
    if (!star_.has(i, star_.outside)) continue;
    const std::uint32_t slot = slots_[star_.slots[static_cast<std::size_t>(i)]];
    state_.first_on_boundary[slot] = kNone;
    if (star_.has(i, kept)) continue;
    std::array<Vec3d, 3> face{link_[static_cast<std::size_t>(kept)], {}, {}};
    std::size_t n = 1;
    for (const std::uint8_t v : star_.triangles[static_cast<std::size_t>(i)])
      if (v != star_.outside) face[n++] = link_[v];
    slots.push_back(slot);
    faces.push_back(face);
  }
  if (faces.empty()) return;
  for (const std::uint32_t v : on_boundary_) {
    const Vec3d p = (state_.mesh.positions[v] - positions_[star_.vertex]) * scale_;
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const double distance = distance_to_triangle(p, faces[i]);
      if (!(distance < least)) continue;
      least = distance;
      nearest = i;
    }
    state_.next_on_boundary[v] = state_.first_on_boundary[slots[nearest]];
    state_.first_on_boundary[slots[nearest]] = v;
  }
}

}  // namespace lode::tetra_mt
