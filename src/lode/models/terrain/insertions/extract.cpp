// P. Cignoni, E. Puppo, R. Scopigno, "Representation and visualization of terrain surfaces at
// variable resolution", Scientific Visualization '95.
#include "lode/models/terrain/insertions/extract.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/delaunay/tin_links.h"
#include "lode/refine/focus.h"
#include "lode/refine/surface_facts.h"

namespace lode::insertions {
namespace {

/// Of the triangles that is_alive(t), of those before `end`.
template <typename IsAlive>
delaunay::Tin collect(const History& history, std::uint32_t end, delaunay::TinLinks links,
                      const IsAlive& is_alive) {
  delaunay::Tin tin;
  for (std::uint32_t t = 0; t < end; ++t) {
    if (!is_alive(t)) continue;
    tin.triangles.push_back(history.triangles[t].corner);
    if (links == delaunay::TinLinks::kept) tin.errors.push_back(history.triangles[t].error);
  }
  place_vertices(history, tin);
  if (links == delaunay::TinLinks::kept) tin.twins = delaunay::find_twins(tin.triangles);
  return tin;
}

/// Applies nodes until no triangle wants more.
class Selection {
 public:
  Selection(const History& history, const Demand& demand)
      : history_(history), demand_(demand), applied_(history.n_nodes()) {}

  AppliedNodes run() {
    for (std::uint32_t t = 0; t < history_.n_base_triangles(); ++t) look_at(t);
    while (!wanted_.empty()) {
      const std::uint32_t node = wanted_.back();
      wanted_.pop_back();
      apply(node);
    }
    return std::move(applied_);
  }

 private:
  void look_at(std::uint32_t t) {
    const Triangle& triangle = history_.triangles[t];
    if (triangle.death == kNone || applied_[triangle.death]) return;
    const auto& [a, b, c] = triangle.corner;
    const NodeFacts facts = facts_of(
        history_, {history_.vertices[a], history_.vertices[b], history_.vertices[c]},
        {history_.heights[a], history_.heights[b], history_.heights[c]}, triangle.error, demand_);
    if (demand_.touches(facts) && to_rank(demand_(facts)) > 0) wanted_.push_back(triangle.death);
  }
  /// After its ancestors, of which there may be long chains.
  void apply(std::uint32_t wanted) {
    chain_.assign(1, wanted);
    while (!chain_.empty()) {
      const std::uint32_t node = chain_.back();
      const std::size_t n_before = chain_.size();
      if (!applied_[node])
        for (const std::uint32_t t : history_.removed_by(node)) {
          const std::uint32_t birth = history_.birth(t);
          if (birth != kNone && !applied_[birth]) chain_.push_back(birth);
        }
      if (chain_.size() > n_before) continue;
      chain_.pop_back();
      if (applied_[node]) continue;
      applied_[node] = true;
      for (std::uint32_t t = history_.first_made[node]; t < history_.first_made[node + 1]; ++t)
        look_at(t);
    }
  }

  const History& history_;
  const Demand& demand_;
  AppliedNodes applied_;
  std::vector<std::uint32_t> wanted_;
  std::vector<std::uint32_t> chain_;
};

constexpr float kLargestFloat = std::numeric_limits<float>::max();

/// How many triangles a node adds.
std::uint64_t growth_of(const History& history, std::uint32_t node) {
  return history.first_made[node + 1] - history.first_made[node] - history.removed_by(node).size();
}

std::uint64_t n_triangles_of(const History& history, const AppliedNodes& applied) {
  std::uint64_t n = history.n_base_triangles();
  for (std::uint32_t node = 0; node < history.n_nodes(); ++node)
    if (applied[node]) n += growth_of(history, node);
  return n;
}

/// The last time with no more triangles.
std::uint32_t time_of_cells(const History& history, std::uint64_t max_cells) {
  std::uint64_t n = history.n_base_triangles();
  std::uint32_t time = 0;
  for (; time < history.n_nodes(); ++time) {
    n += growth_of(history, time);
    if (n > max_cells) break;
  }
  return time;
}

}  // namespace

void place_vertices(const History& history, delaunay::Tin& tin) {
  place_vertices(history.vertices, history.heights, tin);
}

void place_vertices(std::span<const delaunay::LatticePoint> vertices,
                    std::span<const double> heights, delaunay::Tin& tin) {
  std::vector<std::uint32_t> used;
  std::vector<bool> is_used(vertices.size());
  for (const auto& corners : tin.triangles)
    for (const std::uint32_t vertex : corners)
      if (!is_used[vertex]) {
        is_used[vertex] = true;
        used.push_back(vertex);
      }
  std::ranges::sort(used, {}, [&](std::uint32_t vertex) {
    const delaunay::LatticePoint p = vertices[vertex];
    return std::pair(p.y, p.x);
  });
  std::vector<std::uint32_t> number(vertices.size());
  tin.vertices.reserve(used.size());
  tin.heights.reserve(used.size());
  for (const std::uint32_t vertex : used) {
    number[vertex] = static_cast<std::uint32_t>(tin.vertices.size());
    tin.vertices.push_back(vertices[vertex]);
    tin.heights.push_back(heights[vertex]);
  }
  for (auto& corners : tin.triangles)
    for (std::uint32_t& vertex : corners) vertex = number[vertex];
}

delaunay::Tin tin_at(const History& history, std::uint32_t time, delaunay::TinLinks links) {
  return collect(history, history.first_made[time], links, [&](std::uint32_t t) {
    return history.triangles[t].death >= time;  // kNone is later than all.
  });
}

AppliedNodes select_nodes(const History& history, const Demand& demand) {
  return Selection(history, demand).run();
}

NodeSet nodes_within(const History& history, double tolerance) {
  if (history.is_worst_first()) return NodeSet(time_within(history, tolerance));
  return NodeSet(select_nodes(history, uniform_demand(tolerance)));
}

std::optional<NodeSet> nodes_of_cells(const History& history, std::uint64_t max_cells) {
  if (history.n_base_triangles() > max_cells) return {};
  if (history.is_worst_first()) return NodeSet(time_of_cells(history, max_cells));
  // Errors are the upper halves of floats, so tolerances are no more than these.
  std::uint32_t coarse = std::bit_cast<std::uint32_t>(kLargestFloat) >> 16;
  std::uint32_t fine = 0;
  const auto at = [](std::uint32_t half) { return std::bit_cast<float>(half << 16); };
  AppliedNodes best(history.n_nodes());
  while (fine <= coarse) {
    const std::uint32_t middle = (fine + coarse) / 2;
    AppliedNodes applied = select_nodes(history, uniform_demand(static_cast<double>(at(middle))));
    if (n_triangles_of(history, applied) <= max_cells) {
      best = std::move(applied);
      if (middle == 0) break;
      coarse = middle - 1;
    } else {
      fine = middle + 1;
    }
  }
  return NodeSet(std::move(best));
}

delaunay::Tin tin_of(const History& history, const NodeSet& nodes, delaunay::TinLinks links) {
  const auto end = static_cast<std::uint32_t>(history.triangles.size());
  return collect(history, end, links, [&](std::uint32_t t) {
    const std::uint32_t birth = history.birth(t);
    return (birth == kNone || nodes.has(birth)) && !nodes.has(history.triangles[t].death);
  });
}

namespace {

NodeFacts facts_with_bounds(const terrain_file::Source& source,
                            const delaunay::LatticeCorners& corners,
                            const std::array<double, 3>& heights, float error) {
  SurfacePatch patch;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec<double, 2> at = source.frame.world(corners[i].x, corners[i].y);
    patch.add({{at[0], at[1], heights[i]}});
  }
  return patch.facts(static_cast<double>(error), {source.range.lower, source.range.upper});
}

}  // namespace

NodeFacts facts_of(const History& history, const Triangle& triangle) {
  const auto& [a, b, c] = triangle.corner;
  return facts_with_bounds(history, {history.vertices[a], history.vertices[b], history.vertices[c]},
                           {history.heights[a], history.heights[b], history.heights[c]},
                           triangle.error);
}

NodeFacts facts_of(const terrain_file::Source& source, const delaunay::LatticeCorners& corners,
                   const std::array<double, 3>& heights, float error, const Demand& demand) {
  if (demand.uses_bounds()) return facts_with_bounds(source, corners, heights, error);
  const auto [low, high] = std::ranges::minmax(heights);
  NodeFacts facts;
  facts.error = static_cast<double>(error);
  facts.range = {low - facts.error, high + facts.error};
  return facts;
}

}  // namespace lode::insertions
