#include "lode/models/terrain/delaunay_pyramid/mesh_check.h"

#include <algorithm>
#include <utility>

#include "lode/delaunay/lattice.h"
#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/insertions/base_check.h"

namespace lode::delaunay_pyramid {

namespace {

using delaunay::Tin;
using OutlineEdge = std::array<std::uint32_t, 2>;

/// Outline edges by their begins and by their ends.
class OutlineWalk {
 public:
  OutlineWalk(const std::vector<delaunay::LatticePoint>& vertices, std::vector<OutlineEdge> edges)
      : vertices_(vertices), by_begin_(std::move(edges)) {
    std::ranges::sort(by_begin_);
    by_end_.reserve(by_begin_.size());
    for (const auto& [from, to] : by_begin_) by_end_.push_back({to, from});
    std::ranges::sort(by_end_);
  }

  [[nodiscard]] std::vector<OutlineEdge> joined() const {
    std::vector<OutlineEdge> all;
    for (const auto& [from, to] : by_begin_) {
      if (is_straight_at(from)) continue;
      std::uint32_t end = to;
      while (is_straight_at(end)) end = *only(by_begin_, end);
      all.push_back({from, end});
    }
    std::ranges::sort(all);
    return all;
  }

 private:
  /// What the one edge at a vertex leads to.
  static const std::uint32_t* only(const std::vector<OutlineEdge>& edges, std::uint32_t vertex) {
    const auto first = std::ranges::lower_bound(edges, OutlineEdge{vertex, 0});
    const bool is_one = first != edges.end() && (*first)[0] == vertex &&
                        (first + 1 == edges.end() || (first[1])[0] != vertex);
    return is_one ? &(*first)[1] : nullptr;
  }
  [[nodiscard]] bool is_straight_at(std::uint32_t vertex) const {
    const std::uint32_t* const before = only(by_end_, vertex);
    const std::uint32_t* const after = only(by_begin_, vertex);
    return before != nullptr && after != nullptr && *before != *after &&
           delaunay::doubled_area(vertices_[*before], vertices_[vertex], vertices_[*after]) == 0;
  }

  const std::vector<delaunay::LatticePoint>& vertices_;
  std::vector<OutlineEdge> by_begin_;
  std::vector<OutlineEdge> by_end_;  ///< Turned round.
};

std::size_t n_vertices_of(const Tin& mesh, std::size_t n_all) {
  std::vector<bool> is_met(n_all);
  std::size_t n = 0;
  for (const auto& corner : mesh.triangles)
    for (const std::uint32_t v : corner) {
      n += is_met[v] ? 0 : 1;
      is_met[v] = true;
    }
  return n;
}

}  // namespace

Result<void> MeshCheck::check_counts(std::size_t level, const Tin& mesh) const {
  const PyramidHead& head = pyramid_.head;
  if (mesh.triangles.size() != head.n_in_mesh[level])
    return fail("expected a mesh of {} triangles, got one of {}", head.n_in_mesh[level],
                mesh.triangles.size());
  const std::size_t n_met = n_vertices_of(mesh, pyramid_.vertices.size());
  if (n_met != head.vertices_until[level])
    return fail("expected a mesh of {} vertices, got one of {}", head.vertices_until[level], n_met);
  const auto largest = static_cast<double>(*std::ranges::max_element(mesh.errors));
  if (largest != head.facts[level].largest_error)
    return fail("expected triangles whose largest error is {}, got {}",
                head.facts[level].largest_error, largest);
  return {};
}

bool MeshCheck::covers_once(const Tin& mesh) const {
  if (pyramid_.head.source.is_of_points)
    return insertions::cover_part_once(pyramid_.vertices, mesh.triangles);
  std::vector<delaunay::LatticeCorners> places;
  places.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles)
    places.push_back({pyramid_.vertices[a], pyramid_.vertices[b], pyramid_.vertices[c]});
  return insertions::cover_cells_once(places);
}

std::vector<MeshCheck::Edge> MeshCheck::outline_of(
    const Tin& mesh, const std::vector<std::array<std::uint32_t, 3>>& twins) const {
  std::vector<Edge> edges;
  for (std::size_t t = 0; t < twins.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (twins[t][i] == delaunay::kNoHalfEdge)
        edges.push_back({mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]});
  return OutlineWalk(pyramid_.vertices, std::move(edges)).joined();
}

Result<void> MeshCheck::check(std::size_t level) {
  const auto check_mesh = [&]() -> Result<void> {
    const Tin mesh = numbered_mesh(pyramid_, level);
    LODE_CHECK(check_counts(level, mesh));
    if (!covers_once(mesh))
      return fail(
          "expected a mesh that covers its domain once, edge to edge, got one that does not");
    const auto twins = delaunay::find_twins(mesh.triangles);
    if (!pyramid_.head.is_of_lists() && twins != pyramid_.levels[level].twins)
      return fail("expected the neighbours that triangles have, got others");
    std::vector<Edge> outline = outline_of(mesh, twins);
    if (outline_.empty())
      outline_ = std::move(outline);
    else if (outline != outline_)
      return fail("expected the outline of all levels, got another");
    return {};
  };
  if (const auto checked = check_mesh(); !checked)
    return fail("level {}: {}", level, checked.error().message);
  return {};
}

}  // namespace lode::delaunay_pyramid
