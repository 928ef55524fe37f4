#include "lode/models/terrain/terrain_lines/straight_runs.h"

#include <algorithm>

#include "lode/delaunay/lattice.h"

namespace lode::terrain_lines {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// All edges in both directions, once, sorted.
std::vector<Edge> both_ways(std::span<const Edge> edges) {
  std::vector<Edge> sides;
  sides.reserve(2 * edges.size());
  for (const auto& [a, b] : edges) {
    if (a == b) continue;
    sides.push_back({a, b});
    sides.push_back({b, a});
  }
  std::ranges::sort(sides);
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  return sides;
}

class RunFinder {
 public:
  RunFinder(std::span<const LatticePoint> nodes, std::span<const Edge> edges,
            std::span<const std::uint32_t> kept)
      : nodes_(nodes), sides_(both_ways(edges)), kept_(kept.begin(), kept.end()) {
    std::ranges::sort(kept_);
  }

  std::vector<Edge> run() const {
    std::vector<Edge> runs;
    for (const auto& [from, to] : sides_) {
      if (is_passed(from)) continue;
      std::uint32_t before = from;
      std::uint32_t at = to;
      while (is_passed(at)) {
        const std::span<const Edge> ends = at_node(at);
        const std::uint32_t next = ends[0][1] == before ? ends[1][1] : ends[0][1];
        before = at;
        at = next;
      }
      if (from < at) runs.push_back({from, at});
    }
    std::ranges::sort(runs);
    return runs;
  }

 private:
  [[nodiscard]] std::span<const Edge> at_node(std::uint32_t node) const {
    const auto first = std::ranges::lower_bound(sides_, node, {}, &first_of);
    auto end = first;
    while (end != sides_.end() && first_of(*end) == node) ++end;
    return {first, end};
  }
  static std::uint32_t first_of(const Edge& edge) { return edge[0]; }
  /// Whether a run goes on through a node. As lines are straight there, none comes back to itself.
  [[nodiscard]] bool is_passed(std::uint32_t node) const {
    const std::span<const Edge> ends = at_node(node);
    if (ends.size() != 2 || std::ranges::binary_search(kept_, node)) return false;
    const LatticePoint p = nodes_[node];
    const LatticePoint a = nodes_[ends[0][1]];
    const LatticePoint b = nodes_[ends[1][1]];
    const std::int64_t ahead =
        std::int64_t{a.x - p.x} * (b.x - p.x) + std::int64_t{a.y - p.y} * (b.y - p.y);
    return delaunay::doubled_area(a, p, b) == 0 && ahead < 0;
  }

  std::span<const LatticePoint> nodes_;
  std::vector<Edge> sides_;
  std::vector<std::uint32_t> kept_;
};

}  // namespace

std::vector<Edge> straight_runs(std::span<const LatticePoint> nodes, std::span<const Edge> edges,
                                std::span<const std::uint32_t> kept) {
  return RunFinder(nodes, edges, kept).run();
}

}  // namespace lode::terrain_lines
