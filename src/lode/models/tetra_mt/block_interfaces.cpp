// What a collapse does to the boundary and to faces between regions.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "lode/models/tetra_mt/block_collapser.h"
#include "lode/models/tetra_mt/patch_deviation.h"

namespace lode::tetra_mt {
namespace {

/// How far from the faces' planes a vertex may be that goes along them, against its distance.
constexpr double kCoplanar = 1e-6;
constexpr float kNowhere = std::numeric_limits<float>::infinity();

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

/// How far faces are from the reference's if they go along with the vertex, or infinite if they
/// must not. In planes through both ends nothing moves: with each face the vertex that is kept
/// makes no volume.
float BlockCollapser::moved_by(int kept) const {
  if (!goes_along(interfaces_, kept)) return kNowhere;
  const Vec3d& at = link_[static_cast<std::size_t>(kept)];
  const double outline = outline_of(kept);
  bool is_still = outline == 0;
  bool is_flat = outline <= kCoplanar * length(at);
  for (int i = 0; i < interfaces_.n_faces; ++i) {
    const auto& edge = interfaces_.faces[static_cast<std::size_t>(i)].edge;
    if (edge[0] == kept || edge[1] == kept) continue;
    if (edge[0] == star_.outside || edge[1] == star_.outside) continue;
    const Vec3d normal = cross(link_[edge[0]], link_[edge[1]]);
    const double height = std::abs(dot(normal, at));
    is_still = is_still && height == 0;
    is_flat = is_flat && height <= kCoplanar * length(normal) * length(at);
  }
  if (is_still) return deviation_;
  const double before = static_cast<double>(deviation_);
  const double limit = is_flat ? state_.limits.total : state_.limits.step;
  if (!(limit > 0)) return kNowhere;
  double moved = before + deviation_of(kept, limit * scale_) / scale_;
  if (moved > before && moved < static_cast<double>(kNowhere) && !boundary_points_.empty())
    moved = std::min(moved, std::max(before, measured_of(kept, limit * scale_) / scale_));
  return moved <= state_.limits.total ? std::nextafter(static_cast<float>(moved), kNowhere)
                                      : kNowhere;
}

double BlockCollapser::outline_of(int kept) const {
  return outline_height(star_, interfaces_, kept,
                        [this](int place) { return link_[static_cast<std::size_t>(place)]; });
}

/// In the star's unit.
double BlockCollapser::deviation_of(int kept, double limit) const {
  double largest = outline_of(kept);
  std::uint64_t beside = interfaces_.beside[static_cast<std::size_t>(kept)];
  if (star_.is_on_boundary()) beside &= ~(std::uint64_t{1} << star_.outside);
  for (std::uint64_t left = beside; left != 0 && largest <= limit; left &= left - 1) {
    const InterfaceWalk disc = walk(interfaces_, kept, std::countr_zero(left));
    Patch patch{.ring = {}, .n = disc.n, .is_closed = interfaces_.kind == Interfaces::Kind::sheet};
    for (std::size_t i = 0; i < static_cast<std::size_t>(disc.n); ++i)
      patch.ring[i] = link_[disc.places[i]];
    if (patch.is_closed) return sheet_deviation(patch, limit);
    largest = std::max(largest, patch_deviation(patch, limit));
  }
  return largest;
}

/// Of the faces that come, by those of the tetrahedra beside them that stay; of a mesh of one
/// region by those outside alone. What a tetrahedron that goes says of a face that stays, the one
/// beside it in the star says then.
void BlockCollapser::note_deviations(int kept, float moved) {
  if (deviation_ == 0 && moved == 0 && state_.labels.empty()) return;
  for (int i = 0; i < interfaces_.n_faces; ++i)
    for (const std::uint8_t t : interfaces_.faces[static_cast<std::size_t>(i)].triangles)
      if (!star_.has(t, kept)) deviation(t) = std::max(deviation(t), moved);
  if (state_.labels.empty()) return;
  for (int i = 0; i < star_.n_triangles; ++i) {
    if (!star_.has(i, kept) || deviation(i) == 0) continue;
    for (int j = 0; j < star_.n_triangles; ++j) {
      int n_common = 0;
      for (const std::uint8_t v : star_.triangles[static_cast<std::size_t>(i)])
        n_common += v != kept && star_.has(j, v) ? 1 : 0;
      if (n_common == 2 && !star_.has(j, kept)) deviation(j) = std::max(deviation(j), deviation(i));
    }
  }
}

/// Expects the link condition of the mesh.
bool BlockCollapser::keeps_regions(int kept) {
  if (state_.labels.empty() || interfaces_.kind == Interfaces::Kind::none) return true;
  if (!gatherer_.gather(star_.link[static_cast<std::size_t>(kept)], other_)) return false;
  find_interfaces_of(other_, other_interfaces_);
  return keeps_interfaces(star_, interfaces_, kept, other_, other_interfaces_);
}

}  // namespace lode::tetra_mt
