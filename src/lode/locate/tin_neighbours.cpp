#include "lode/locate/tin_neighbours.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <tuple>
#include <utility>

namespace lode {
namespace {

bool is_in(const std::vector<std::uint32_t>& sorted, std::uint32_t triangle) {
  return std::ranges::binary_search(sorted, triangle);
}

}  // namespace

TinNeighbours::TinNeighbours(const delaunay::Tin& tin, std::int32_t period)
    : tin_(tin), period_(period) {
  for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i)
      if (tin.twins.empty() || tin.twins[t][i] == delaunay::kNoHalfEdge)
        lone_.push_back(lone_edge(t, i));
  std::ranges::sort(lone_, {}, [](const LoneEdge& one) {
    return std::tuple(one.dx, one.dy, one.offset, one.is_left, one.begin, one.half_edge);
  });
}

TinNeighbours::LoneEdge TinNeighbours::lone_edge(std::uint32_t triangle, std::uint32_t edge) const {
  delaunay::LatticePoint a = tin_.vertices[tin_.triangles[triangle][edge]];
  delaunay::LatticePoint b = tin_.vertices[tin_.triangles[triangle][(edge + 1) % 3]];
  if (period_ > 0 && a.x == period_ && b.x == period_) a.x = b.x = 0;
  // Triangles turn left: they are to the left of their edges.
  const bool is_left = a.x < b.x || (a.x == b.x && a.y < b.y);
  if (!is_left) std::swap(a, b);
  LoneEdge one{.is_left = is_left, .half_edge = 4 * triangle + edge};
  const std::int32_t factor = std::gcd(b.x - a.x, b.y - a.y);
  one.dx = (b.x - a.x) / factor;
  one.dy = (b.y - a.y) / factor;
  one.offset = std::int64_t{one.dx} * a.y - std::int64_t{one.dy} * a.x;
  one.begin = one.dx != 0 ? a.x : a.y;
  one.end = one.dx != 0 ? b.x : b.y;
  return one;
}

/// From low to high coordinates.
template <typename Visit>
void TinNeighbours::visit_beside(std::uint32_t triangle, std::uint32_t edge,
                                 const Visit& visit) const {
  if (!tin_.twins.empty() && tin_.twins[triangle][edge] != delaunay::kNoHalfEdge)
    return visit(tin_.twins[triangle][edge]);
  const LoneEdge own = lone_edge(triangle, edge);
  const auto line_of = [](const LoneEdge& one) {
    return std::tuple(one.dx, one.dy, one.offset, one.is_left);
  };
  const auto other_side = std::tuple(own.dx, own.dy, own.offset, !own.is_left);
  // On one side of a line edges do not overlap, so that they end in their order, too.
  auto at = std::ranges::partition_point(lone_, [&](const LoneEdge& one) {
    return line_of(one) < other_side || (line_of(one) == other_side && one.end <= own.begin);
  });
  for (; at != lone_.end() && line_of(*at) == other_side && at->begin < own.end; ++at)
    visit(at->half_edge);
}

std::vector<TinNeighbours::Beside> TinNeighbours::beside(std::uint32_t triangle,
                                                         std::uint32_t edge) const {
  std::vector<Beside> found;
  visit_beside(triangle, edge, [&](std::uint32_t half_edge) {
    found.push_back({half_edge / 4, half_edge % 4});
  });
  if (found.size() > 1 && !lone_edge(triangle, edge).is_left) std::ranges::reverse(found);
  return found;
}

std::vector<RingTriangle> TinNeighbours::rings(std::vector<std::uint32_t> start,
                                               std::uint32_t n_rings) const {
  const auto make_set = [](std::vector<std::uint32_t>& triangles) {
    std::ranges::sort(triangles);
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  };
  make_set(start);
  std::vector<RingTriangle> all;
  std::vector<std::uint32_t> last;
  std::vector<std::uint32_t> ring = std::move(start);
  for (std::uint32_t i = 0; !ring.empty(); ++i) {
    std::ranges::transform(ring, std::back_inserter(all), [i](std::uint32_t t) {
      return RingTriangle{t, i};
    });
    if (i == n_rings) break;
    // What is beside a ring is in it, in the one before or in the next.
    std::vector<std::uint32_t> next;
    for (const std::uint32_t t : ring)
      for (std::uint32_t edge = 0; edge < 3; ++edge)
        visit_beside(t, edge, [&](std::uint32_t half_edge) {
          const std::uint32_t other = half_edge / 4;
          if (!is_in(ring, other) && !is_in(last, other)) next.push_back(other);
        });
    make_set(next);
    last = std::exchange(ring, std::move(next));
  }
  return all;
}

}  // namespace lode
