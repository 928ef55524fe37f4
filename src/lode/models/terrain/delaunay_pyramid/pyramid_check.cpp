#include "lode/models/terrain/delaunay_pyramid/pyramid_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticeCorners;
using delaunay::LatticePoint;
using Edge = std::array<std::uint32_t, 2>;
using Triple = std::array<std::uint32_t, 3>;

/// The mesh of a level that links lead to. What they count is kept with the level, and comes last
/// in the mesh.
class LinkedMesh {
 public:
  LinkedMesh(const Pyramid& pyramid, std::size_t level)
      : pyramid_(pyramid),
        triangles_(numbered_mesh(pyramid, level).triangles),
        twins_(delaunay::find_twins(triangles_)),
        n_before_(pyramid.head.n_in_mesh[level] - pyramid.head.n_kept[level]),
        seen_(triangles_.size()) {}

  /// Whether links are those to all that meets a triangle's interior.
  [[nodiscard]] bool are_all_of(const Triple& triangle, std::span<const std::uint32_t> links) {
    const LatticeCorners own = corners(triangle);
    ++round_;
    open_.clear();
    found_.clear();
    if (!links.empty()) push(n_before_ + links[0], own);
    while (!open_.empty()) {
      const std::uint32_t t = open_.back();
      open_.pop_back();
      found_.push_back(t);
      for (const std::uint32_t behind : twins_[t])
        if (behind != delaunay::kNoHalfEdge) push(behind / 4, own);
    }
    std::ranges::sort(found_);
    return std::ranges::equal(found_, links, {}, {},
                              [&](std::uint32_t link) { return n_before_ + link; });
  }

 private:
  [[nodiscard]] LatticeCorners corners(const Triple& triangle) const {
    return {pyramid_.vertices[triangle[0]], pyramid_.vertices[triangle[1]],
            pyramid_.vertices[triangle[2]]};
  }
  void push(std::uint32_t t, const LatticeCorners& own) {
    if (seen_[t] == round_) return;
    seen_[t] = round_;
    if (insertions::do_interiors_meet(own, corners(triangles_[t]))) open_.push_back(t);
  }

  const Pyramid& pyramid_;
  std::vector<Triple> triangles_;
  std::vector<Triple> twins_;
  std::uint32_t n_before_;
  std::vector<std::uint32_t> seen_;  ///< By triangle: in which round it was.
  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> open_;
  std::vector<std::uint32_t> found_;
};

/// Of links that lead to a level, from those kept with the level `from`.
void check_links(const Pyramid& pyramid, std::size_t from, std::size_t to, LinkedMesh& mesh,
                 PyramidFaults& faults) {
  const PyramidLevel& kept = pyramid.levels[from];
  for (std::uint32_t t = 0; t < kept.triangles.size(); ++t) {
    if (pyramid.head.is_of_lists() && kept.deaths[t] != to) continue;
    const auto links = kept.links.of(t);
    ++faults.n_owners;
    faults.n_links += links.size();
    if (!mesh.are_all_of(kept.triangles[t], links)) ++faults.n_wrong_owners;
  }
}

/// The edges of a mesh that lie on lines; nothing where one of these is no chain of them.
class LineEdges {
 public:
  LineEdges(const std::vector<LatticePoint>& vertices, const std::vector<Triple>& triangles)
      : vertices_(vertices) {
    for (const Triple& corner : triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = corner[i];
        const std::uint32_t b = corner[(i + 1) % 3];
        edges_.push_back({a, b});
        edges_.push_back({b, a});
      }
    std::ranges::sort(edges_);
  }

  [[nodiscard]] std::optional<std::vector<Edge>> on(std::span<const Edge> lines) const {
    std::vector<Edge> all;
    for (const auto& [from, to] : lines)
      for (std::uint32_t at = from; at != to;) {
        const auto next = next_to(at, to);
        if (!next) return {};
        all.push_back({at, *next});
        at = *next;
      }
    return all;
  }

 private:
  /// Along an edge that is a part of the way to `to`, or all of it.
  [[nodiscard]] std::optional<std::uint32_t> next_to(std::uint32_t at, std::uint32_t to) const {
    const LatticePoint p = vertices_[at];
    const LatticePoint end = vertices_[to];
    const auto is_between = [](std::int32_t x, std::int32_t a, std::int32_t b) {
      return x >= std::min(a, b) && x <= std::max(a, b);
    };
    for (auto edge = std::ranges::lower_bound(edges_, Edge{at, 0});
         edge != edges_.end() && (*edge)[0] == at; ++edge) {
      const std::uint32_t b = (*edge)[1];
      const LatticePoint q = vertices_[b];
      if (delaunay::doubled_area(p, end, q) == 0 && is_between(q.x, p.x, end.x) &&
          is_between(q.y, p.y, end.y))
        return b;
    }
    return {};
  }

  const std::vector<LatticePoint>& vertices_;
  std::vector<Edge> edges_;  ///< From either end.
};

/// Angles are computed, elsewhere perhaps otherwise in the last places.
bool has_angles(const MeshFacts& said, const MeshFacts& found) {
  constexpr double kRounding = 1e-6;
  return std::abs(said.smallest_angle - found.smallest_angle) < kRounding &&
         std::abs(said.median_angle - found.median_angle) < kRounding;
}

void check_mesh(const Pyramid& pyramid, std::size_t level, PyramidFaults& faults) {
  const delaunay::Tin numbered = numbered_mesh(pyramid, level);
  const std::vector<Triple>& triangles = numbered.triangles;
  if (!has_angles(pyramid.head.facts[level], facts_of(pyramid, numbered))) ++faults.n_other_angles;
  delaunay::PointMesh mesh(delaunay::ListedNodes(pyramid.vertices), triangles);
  if (!pyramid.lines.empty()) {
    const auto fixed = LineEdges(pyramid.vertices, triangles).on(pyramid.lines);
    if (!fixed) {
      ++faults.n_line_levels;
      return;
    }
    mesh.cut(*fixed);
  }
  if (!mesh.is_delaunay()) ++faults.n_other_levels;
}

}  // namespace

Result<PyramidFaults> find_faults(const Pyramid& pyramid, Progress& progress) {
  PyramidFaults faults;
  const std::size_t n_levels = pyramid.head.n_levels();
  for (std::size_t level = 0; level < n_levels; ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("checking levels", static_cast<double>(level) / static_cast<double>(n_levels));
    check_mesh(pyramid, level, faults);
    if (level == 0 || !has_links(pyramid.head.encoding)) continue;
    LinkedMesh mesh(pyramid, level);
    for (std::size_t from = pyramid.head.is_of_lists() ? 0 : level - 1; from < level; ++from)
      check_links(pyramid, from, level, mesh, faults);
  }
  return faults;
}

}  // namespace lode::delaunay_pyramid
