// Filling holes by ears whose circles hold none of the hole's vertices: O. Devillers, "On deletion
// in Delaunay triangulations", 1999, without its queue, as holes are small.
#include "lode/models/terrain/implicit_pyramid/thinned_mesh.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "lode/core/expects.h"

namespace lode::implicit_pyramid {

using delaunay::kNoHalfEdge;
using delaunay::LatticePoint;

namespace {

constexpr std::size_t kNoEar = std::numeric_limits<std::size_t>::max();

std::uint32_t next_of(std::uint32_t i) { return i < 2 ? i + 1 : 0; }
std::uint32_t previous_of(std::uint32_t i) { return i > 0 ? i - 1 : 2; }

}  // namespace

ThinnedMesh::ThinnedMesh(delaunay::Tin tin)
    : tin_(std::move(tin)), triangle_of_(tin_.vertices.size()) {
  for (std::uint32_t t = 0; t < tin_.triangles.size(); ++t)
    for (const std::uint32_t vertex : tin_.triangles[t]) triangle_of_[vertex] = t;
}

void ThinnedMesh::walk_round(std::uint32_t vertex) {
  const auto place_in = [&](std::uint32_t t) {
    const auto& corner = tin_.triangles[t];
    return corner[0] == vertex ? 0U : corner[1] == vertex ? 1U : 2U;
  };
  // To the right as far as it goes, once round at most.
  const std::uint32_t some = triangle_of_[vertex];
  std::uint32_t first = some;
  for (;;) {
    const std::uint32_t twin = tin_.twins[first][place_in(first)];
    if (twin == kNoHalfEdge) break;
    first = twin >> 2;
    if (first == some) break;
  }
  ring_.clear();
  star_.clear();
  hole_.clear();
  for (std::uint32_t t = first;;) {
    const std::uint32_t i = place_in(t);
    ring_.push_back(tin_.triangles[t][next_of(i)]);
    star_.push_back(t);
    hole_.push_back({ring_.back(), tin_.twins[t][next_of(i)]});
    const std::uint32_t twin = tin_.twins[t][previous_of(i)];
    if (twin == kNoHalfEdge) {
      // On the outline, whose edge goes on through it.
      ring_.push_back(tin_.triangles[t][previous_of(i)]);
      hole_.push_back({ring_.back(), kNoHalfEdge});
      return;
    }
    t = twin >> 2;
    if (t == first) return;
  }
}

const std::vector<std::uint32_t>& ThinnedMesh::neighbours(std::uint32_t vertex) {
  walk_round(vertex);
  return ring_;
}

void ThinnedMesh::remove(std::uint32_t vertex) {
  walk_round(vertex);
  LODE_EXPECTS(ring_.size() >= 3);
  fill_hole();
}

std::size_t ThinnedMesh::count_inside(std::size_t ear) const {
  const std::size_t n = hole_.size();
  const std::size_t middle = ear + 1 < n ? ear + 1 : 0;
  const std::size_t last = middle + 1 < n ? middle + 1 : 0;
  const auto at = [&](std::size_t i) { return tin_.vertices[hole_[i].from]; };
  const LatticePoint a = at(ear);
  const LatticePoint b = at(middle);
  const LatticePoint c = at(last);
  if (delaunay::doubled_area(a, b, c) <= 0) return kNoEar;
  std::size_t n_inside = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == ear || i == middle || i == last) continue;
    const LatticePoint p = at(i);
    if (delaunay::doubled_area(a, b, p) >= 0 && delaunay::doubled_area(b, c, p) >= 0 &&
        delaunay::doubled_area(c, a, p) >= 0)
      return kNoEar;
    if (delaunay::is_in_circle(a, b, c, p)) ++n_inside;
  }
  return n_inside;
}

std::size_t ThinnedMesh::find_ear() const {
  std::size_t best = kNoEar;
  std::size_t best_ear = kNoEar;
  for (std::size_t ear = 0; ear < hole_.size() && best > 0; ++ear)
    // Behind the outline there may be vertices in all circles.
    if (const std::size_t n_inside = count_inside(ear); n_inside < best) {
      best = n_inside;
      best_ear = ear;
    }
  LODE_EXPECTS(best_ear != kNoEar);
  return best_ear;
}

void ThinnedMesh::set(std::uint32_t t, const std::array<std::uint32_t, 3>& corner,
                      const std::array<std::uint32_t, 3>& twin) {
  tin_.triangles[t] = corner;
  tin_.twins[t] = twin;
  for (std::uint32_t i = 0; i < 3; ++i) {
    triangle_of_[corner[i]] = t;
    if (twin[i] != kNoHalfEdge) tin_.twins[twin[i] >> 2][twin[i] & 3] = 4 * t + i;
  }
}

void ThinnedMesh::fill_hole() {
  // Ties are settled by the hole alone, whatever was removed before.
  std::rotate(hole_.begin(), std::ranges::min_element(hole_, {}, &HoleEdge::from), hole_.end());
  std::size_t n_filled = 0;
  while (hole_.size() > 3) {
    const std::size_t ear = find_ear();
    const std::size_t middle = ear + 1 < hole_.size() ? ear + 1 : 0;
    const std::size_t last = middle + 1 < hole_.size() ? middle + 1 : 0;
    const std::uint32_t t = star_[n_filled++];
    set(t, {hole_[ear].from, hole_[middle].from, hole_[last].from},
        {hole_[ear].twin, hole_[middle].twin, kNoHalfEdge});
    hole_[ear].twin = 4 * t + 2;
    hole_.erase(hole_.begin() + static_cast<std::ptrdiff_t>(middle));
  }
  set(star_[n_filled], {hole_[0].from, hole_[1].from, hole_[2].from},
      {hole_[0].twin, hole_[1].twin, hole_[2].twin});
}

}  // namespace lode::implicit_pyramid
