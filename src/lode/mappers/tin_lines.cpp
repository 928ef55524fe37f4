#include "lode/mappers/tin_lines.h"

#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include "lode/delaunay/lattice.h"

namespace lode {
namespace {

std::uint64_t place_key(LatticePoint p) {
  return (std::uint64_t{static_cast<std::uint32_t>(p.y)} << 32) | static_cast<std::uint32_t>(p.x);
}

/// By vertex, the other ends of the edges that triangles have in their direction, and, once more,
/// of those against it.
class Neighbours {
 public:
  Neighbours(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t n_vertices)
      : first_(n_vertices + 1, 0) {
    for (const auto& t : triangles)
      for (const std::uint32_t v : t) first_[v + 1] += 2;
    for (std::size_t v = 0; v < n_vertices; ++v) first_[v + 1] += first_[v];
    ends_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const auto& t : triangles)
      for (std::size_t i = 0; i < 3; ++i)
        for (const std::size_t step : {1U, 2U}) ends_[next[t[i]]++] = t[(i + step) % 3];
  }
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t v) const {
    return std::span(ends_).subspan(first_[v], first_[v + 1] - first_[v]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> ends_;
};

/// Of p - a along b - a: not negative and no more than its length.
bool is_on_way(LatticePoint a, LatticePoint b, LatticePoint p) {
  const auto within = [](std::int32_t from, std::int32_t to, std::int32_t at) {
    return from <= to ? from <= at && at <= to : to <= at && at <= from;
  };
  return delaunay::doubled_area(a, b, p) == 0 && within(a.x, b.x, p.x) && within(a.y, b.y, p.y);
}

}  // namespace

TinLines::TinLines(std::span<const std::array<std::uint32_t, 3>> triangles,
                   std::span<const LatticePoint> nodes,
                   std::span<const std::array<LatticePoint, 2>> lines) {
  if (lines.empty()) return;
  const Neighbours neighbours(triangles, nodes.size());
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_at;
  for (std::uint32_t v = 0; v < nodes.size(); ++v) vertex_at.emplace(place_key(nodes[v]), v);
  for (const auto& [from, to] : lines) {
    const auto start = vertex_at.find(place_key(from));
    std::optional<std::uint32_t> at;
    if (start != vertex_at.end()) at = start->second;
    while (at && nodes[*at] != to) {
      std::optional<std::uint32_t> next;
      for (const std::uint32_t end : neighbours.of(*at))
        if (nodes[end] != nodes[*at] && is_on_way(nodes[*at], to, nodes[end])) next = end;
      if (next) edges_.insert(key(*at, *next));
      at = next;
    }
    n_broken_ += static_cast<std::uint64_t>(!at.has_value());
  }
}

}  // namespace lode
