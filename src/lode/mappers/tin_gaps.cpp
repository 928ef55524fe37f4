#include "lode/mappers/tin_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace lode {
namespace {

using delaunay::LatticePoint;

struct HangingVertex {
  std::uint32_t vertex;
  std::uint32_t from;  ///< The edge's ends,
  std::uint32_t to;
  double share;         ///< and how far along it.
  std::int64_t length;  ///< Of the edge, squared.
};

/// Edges that one triangle alone has, smaller number first.
std::vector<std::array<std::uint32_t, 2>> lone_edges(const delaunay::Tin& tin) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const auto& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back({std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])});
  std::ranges::sort(edges);
  std::vector<std::array<std::uint32_t, 2>> lone;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end == i + 1) lone.push_back(edges[i]);
    i = end;
  }
  return lone;
}

/// Finds vertices by their places.
class VertexFinder {
 public:
  explicit VertexFinder(const delaunay::Tin& tin) : tin_(tin), order_(tin.vertices.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    std::ranges::sort(order_, {}, [&](std::uint32_t v) { return key(tin_.vertices[v]); });
  }
  [[nodiscard]] std::optional<std::uint32_t> find(LatticePoint p) const {
    const auto at = std::ranges::lower_bound(
        order_, key(p), {}, [&](std::uint32_t v) { return key(tin_.vertices[v]); });
    if (at == order_.end() || tin_.vertices[*at] != p) return {};
    return *at;
  }

 private:
  static std::pair<std::int32_t, std::int32_t> key(LatticePoint p) { return {p.y, p.x}; }

  const delaunay::Tin& tin_;
  std::vector<std::uint32_t> order_;
};

std::vector<HangingVertex> find_hanging(const delaunay::Tin& tin) {
  std::vector<HangingVertex> hanging;
  const VertexFinder vertices(tin);
  for (const auto& [from, to] : lone_edges(tin)) {
    const LatticePoint a = tin.vertices[from];
    const LatticePoint b = tin.vertices[to];
    const std::int32_t dx = b.x - a.x;
    const std::int32_t dy = b.y - a.y;
    const std::int32_t n = std::gcd(dx, dy);
    for (std::int32_t k = 1; k < n; ++k)
      if (const auto at = vertices.find({a.x + dx / n * k, a.y + dy / n * k}))
        hanging.push_back({*at, from, to, static_cast<double>(k) / n,
                           std::int64_t{dx} * dx + std::int64_t{dy} * dy});
  }
  return hanging;
}

double height_at(const delaunay::Tin& tin, const HangingVertex& at) {
  return tin.heights[at.from] + (tin.heights[at.to] - tin.heights[at.from]) * at.share;
}

}  // namespace

TinGaps measure_gaps(const delaunay::Tin& tin) {
  TinGaps gaps;
  std::vector<bool> is_counted(tin.vertices.size());
  for (const HangingVertex& at : find_hanging(tin)) {
    if (!is_counted[at.vertex]) ++gaps.n_hanging;
    is_counted[at.vertex] = true;
    gaps.largest = std::max(gaps.largest, std::abs(tin.heights[at.vertex] - height_at(tin, at)));
  }
  return gaps;
}

void close_gaps(delaunay::Tin& tin) {
  std::vector<HangingVertex> hanging = find_hanging(tin);
  std::ranges::stable_sort(hanging, std::greater(), &HangingVertex::length);
  std::vector<bool> is_moved(tin.vertices.size());
  for (const HangingVertex& at : hanging) {
    if (is_moved[at.vertex]) continue;
    is_moved[at.vertex] = true;
    tin.heights[at.vertex] = height_at(tin, at);
  }
  tin.errors.clear();
}

}  // namespace lode
