#include "lode/models/terrain/delaunay_selector/spatial_order.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace lode::delaunay_selector {
namespace {

/// Its bits with a zero before each.
std::uint64_t spread_bits(std::int32_t x) {
  std::uint64_t bits = static_cast<std::uint32_t>(x);
  bits = (bits | bits << 16) & 0x0000ffff0000ffffU;
  bits = (bits | bits << 8) & 0x00ff00ff00ff00ffU;
  bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0fU;
  bits = (bits | bits << 2) & 0x3333333333333333U;
  return (bits | bits << 1) & 0x5555555555555555U;
}

}  // namespace

SpatialOrder::SpatialOrder(const HeightPoints& points, const PointDomain& domain) {
  const std::size_t n = points.nodes.size();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(n);
  for (std::uint32_t i = 0; i < n; ++i)
    order.emplace_back(spread_bits(points.nodes[i].x) | spread_bits(points.nodes[i].y) << 1, i);
  std::ranges::sort(order);
  std::vector<std::uint32_t> number(n);
  nodes.reserve(n);
  heights.reserve(n);
  triangle_of.reserve(n);
  for (const auto& [key, i] : order) {
    number[i] = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(points.nodes[i]);
    heights.push_back(points.heights[i]);
    triangle_of.push_back(domain.triangle_of[i]);
  }
  triangles.reserve(domain.triangles.size());
  for (const auto& t : domain.triangles)
    triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  for (const auto& [a, b] : domain.lines) lines.push_back({number[a], number[b]});
}

delaunay::PointMesh SpatialOrder::mesh() const {
  delaunay::PointMesh made(delaunay::ListedNodes(nodes), triangles);
  if (!lines.empty()) made.cut(lines);
  return made;
}

delaunay::Tin SpatialOrder::to_tin(const delaunay::PointMesh& mesh,
                                   delaunay::TinLinks links) const {
  delaunay::Tin tin = delaunay::to_tin(mesh, links);
  const std::size_t n = tin.vertices.size();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> rows;
  rows.reserve(n);
  std::vector<double> found;
  found.reserve(n);
  std::size_t at = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const LatticePoint p = tin.vertices[i];
    while (nodes[at] != p) ++at;
    found.push_back(heights[at]);
    rows.emplace_back(
        std::uint64_t{static_cast<std::uint32_t>(p.y)} << 32 | static_cast<std::uint32_t>(p.x), i);
  }
  std::ranges::sort(rows);
  std::vector<std::uint32_t> number(n);
  tin.heights.reserve(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto& [row, from] = rows[i];
    number[from] = i;
    tin.vertices[i] = {static_cast<std::int32_t>(row & 0xffffffffU),
                       static_cast<std::int32_t>(row >> 32)};
    tin.heights.push_back(found[from]);
  }
  for (auto& t : tin.triangles)
    for (std::uint32_t& corner : t) corner = number[corner];
  return tin;
}

}  // namespace lode::delaunay_selector
