#include "lode/models/terrain/triangle_hierarchy/tin_walk.h"

#include <cmath>
#include <cstddef>
#include <numeric>

namespace lode::triangle_hierarchy {
namespace {

using delaunay::kNoHalfEdge;
using delaunay::LatticePoint;

}  // namespace

TinWalker::TinWalker(const delaunay::Tin& tin, const TinLocator& locator, int bits)
    : tin_(tin), locator_(locator), bits_(bits), first_(tin.vertices.size() + 1) {
  for (const auto& corner : tin.triangles)
    for (const std::uint32_t v : corner) ++first_[v + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  round_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < tin.triangles.size(); ++t)
    for (const std::uint32_t v : tin.triangles[t]) round_[next[v]++] = t;
}

int TinWalker::side_of(const Segment& segment, std::uint32_t vertex) const {
  const std::int64_t area = delaunay::doubled_area(segment.a, segment.b, fine(vertex));
  return static_cast<int>(area > 0) - static_cast<int>(area < 0);
}

bool TinWalker::is_ahead(const Segment& segment, LatticePoint from, LatticePoint to) const {
  return std::int64_t{to.x - from.x} * (segment.b.x - segment.a.x) +
             std::int64_t{to.y - from.y} * (segment.b.y - segment.a.y) >
         0;
}

std::uint32_t TinWalker::triangle_at(LatticePoint at) const {
  return locator_.find({{std::ldexp(at.x, -bits_), std::ldexp(at.y, -bits_)}})
      .value_or(kNoHalfEdge);
}

TinWalker::Step TinWalker::start(const Segment& segment) const {
  const std::uint32_t triangle = triangle_at(segment.a);
  if (triangle == kNoHalfEdge) return {};
  for (const std::uint32_t v : tin_.triangles[triangle])
    if (fine(v) == segment.a) return leave_vertex(segment, v);
  const Step step = leave(segment, triangle);
  if (step.half_edge == kNoHalfEdge) return step;
  // Where it begins on that very edge, it goes out of the triangle at once.
  const auto& corner = tin_.triangles[triangle];
  const std::uint32_t edge = step.half_edge % 4;
  if (delaunay::doubled_area(fine(corner[edge]), fine(corner[kNextCorner[edge]]), segment.a) != 0)
    return step;
  const std::uint32_t twin = tin_.twins[triangle][edge];
  return twin == kNoHalfEdge ? Step{} : leave(segment, twin / 4);
}

/// Of a triangle that holds the segment's start, which is no corner.
TinWalker::Step TinWalker::leave(const Segment& segment, std::uint32_t triangle) const {
  const auto& corner = tin_.triangles[triangle];
  std::array<int, 3> side{};
  for (std::uint32_t i = 0; i < 3; ++i) {
    side[i] = side_of(segment, corner[i]);
    if (side[i] == 0 && is_ahead(segment, segment.a, fine(corner[i])))
      return {.vertex = corner[i], .triangle = triangle};
  }
  for (std::uint32_t i = 0; i < 3; ++i)
    if (side[i] < 0 && side[kNextCorner[i]] > 0) return {.half_edge = 4 * triangle + i};
  return {};
}

TinWalker::Step TinWalker::leave_vertex(const Segment& segment, std::uint32_t vertex) const {
  const LatticePoint at = fine(vertex);
  for (const std::uint32_t t : triangles_round(vertex)) {
    const auto& corner = tin_.triangles[t];
    const std::uint32_t i = corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
    const std::uint32_t from = kNextCorner[i];
    const std::uint32_t to = kNextCorner[from];
    const int right = side_of(segment, corner[from]);
    const int left = side_of(segment, corner[to]);
    if (right == 0 && is_ahead(segment, at, fine(corner[from])))
      return {.vertex = corner[from], .triangle = t};
    if (left == 0 && is_ahead(segment, at, fine(corner[to])))
      return {.vertex = corner[to], .triangle = t};
    if (right < 0 && left > 0) return {.half_edge = 4 * t + from};
  }
  return {};
}

TinWalker::Step TinWalker::cross(const Segment& segment, std::uint32_t half_edge) const {
  const std::uint32_t twin = tin_.twins[half_edge / 4][half_edge % 4];
  if (twin == kNoHalfEdge) return {};
  const std::uint32_t triangle = twin / 4;
  const std::uint32_t next = kNextCorner[twin % 4];
  const std::uint32_t opposite = kNextCorner[next];
  const std::uint32_t vertex = tin_.triangles[triangle][opposite];
  const int side = side_of(segment, vertex);
  if (side == 0) return {.vertex = vertex, .triangle = triangle};
  return {.half_edge = 4 * triangle + (side < 0 ? opposite : next)};
}

}  // namespace lode::triangle_hierarchy
