#include "lode/models/terrain/insertions/fixed_edges.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace lode::insertions {
namespace {

using delaunay::LatticePoint;

/// A node, or a triangle's middle, three times its coordinates: below 2^32.
struct Tripled {
  std::int64_t x;
  std::int64_t y;
};

Tripled tripled(LatticePoint p) { return {3 * std::int64_t{p.x}, 3 * std::int64_t{p.y}}; }

/// On which side of the way from a to b a place is.
int side_of_way(Tripled a, Tripled b, Tripled p) {
  __extension__ using Int128 = __int128;
  const Int128 left = static_cast<Int128>(b.x - a.x) * (p.y - a.y);
  const Int128 right = static_cast<Int128>(b.y - a.y) * (p.x - a.x);
  return left > right ? 1 : left < right ? -1 : 0;
}

/// Whether each crosses the other, and does not only touch it.
bool do_cross(Tripled a, Tripled b, Tripled c, Tripled d) {
  return side_of_way(a, b, c) * side_of_way(a, b, d) < 0 &&
         side_of_way(c, d, a) * side_of_way(c, d, b) < 0;
}

/// Whether the base is all of its frame, which has nothing that is hidden.
bool is_rectangle(const History& base) {
  std::int64_t doubled = 0;
  for (const Triangle& triangle : base.triangles)
    doubled +=
        delaunay::doubled_area(base.vertices[triangle.corner[0]], base.vertices[triangle.corner[1]],
                               base.vertices[triangle.corner[2]]);
  return base.lines.empty() &&
         doubled == 2 * std::int64_t{base.frame.n_columns - 1} * (base.frame.n_rows - 1);
}

}  // namespace

FixedEdges::FixedEdges(const History& base) {
  if (is_rectangle(base)) return;
  using Ends = std::array<std::uint32_t, 2>;
  std::vector<Ends> all;
  for (const Triangle& triangle : base.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      all.push_back({triangle.corner[i], triangle.corner[(i + 1) % 3]});
  std::ranges::sort(all);
  std::vector<Ends> fixed = base.lines;
  for (const auto& [a, b] : all)
    if (!std::ranges::binary_search(all, Ends{b, a})) fixed.push_back({a, b});
  for (const auto& [a, b] : fixed) edges_.push_back({base.vertices[a], base.vertices[b]});
  std::ranges::sort(edges_, {}, [](const Edge& edge) {
    return std::pair(place_along_z(edge.from), place_along_z(edge.to));
  });
  std::vector<LatticeBox> boxes(edges_.size());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    boxes[i].add(edges_[i].from);
    boxes[i].add(edges_[i].to);
  }
  boxes_ = BoxTree(std::move(boxes));
}

bool FixedEdges::hide(const delaunay::LatticeCorners& triangle, LatticePoint p) const {
  Tripled middle{0, 0};
  for (const LatticePoint& corner : triangle) {
    middle.x += corner.x;
    middle.y += corner.y;
  }
  LatticeBox way = box_of(triangle);
  way.add(p);
  bool hides = false;
  boxes_.for_each([&](const LatticeBox& box) { return box.meets(way); },
                  [&](std::uint32_t i) {
                    hides = do_cross(middle, tripled(p), tripled(edges_[i].from),
                                     tripled(edges_[i].to));
                    return !hides;
                  });
  return hides;
}

}  // namespace lode::insertions
