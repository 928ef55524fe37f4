// L. De Floriani, E. Puppo, "Hierarchical triangulation for multiresolution surface description",
// ACM Transactions on Graphics 14 (1995): variable resolution; that patches have errors, and are
// refined where these are too large, is ours.
#include "lode/models/terrain/triangle_hierarchy/variable.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "lode/core/flat_index.h"
#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/triangle_hierarchy/polygon.h"
#include "lode/refine/surface_facts.h"

namespace lode::triangle_hierarchy {
namespace {

using Corners = std::array<std::uint32_t, 3>;

NodeFacts facts_of(const Hierarchy& hierarchy, const Corners& corners, double error) {
  SurfacePatch patch;
  for (const std::uint32_t v : corners) {
    const delaunay::LatticePoint p = hierarchy.vertices[v];
    const Vec<double, 2> at =
        hierarchy.frame.world(std::ldexp(p.x, -hierarchy.bits), std::ldexp(p.y, -hierarchy.bits));
    patch.add({{at[0], at[1], hierarchy.heights[v]}});
  }
  return patch.facts(error);
}

/// The triangles of a mesh of mixed levels, by their directed edges.
class Leaves {
 public:
  Leaves(const Hierarchy& hierarchy, const EdgeChains& chains)
      : hierarchy_(hierarchy), chains_(chains) {}

  void add(std::uint32_t triangle) {
    const Corners& corner = hierarchy_.triangles[triangle].corner;
    for (std::size_t i = 0; i < 3; ++i)
      edges_.insert(key(corner[i], corner[(i + 1) % 3]), triangle);
  }
  void remove(std::uint32_t triangle) {
    const Corners& corner = hierarchy_.triangles[triangle].corner;
    for (std::size_t i = 0; i < 3; ++i) edges_.erase(key(corner[i], corner[(i + 1) % 3]));
  }
  /// What is behind an edge, and has it whole or as a part of one of its own; kNone: what is there
  /// is smaller, or nothing is.
  [[nodiscard]] std::uint32_t find_behind(std::uint32_t from, std::uint32_t to) const {
    while (true) {
      const std::uint32_t found = edges_.find(key(to, from));
      if (found != FlatIndex::kNone) return found;
      const auto whole = chains_.find_whole(from, to);
      if (!whole) return kNone;
      from = (*whole)[0];
      to = (*whole)[1];
    }
  }
  /// The vertices that what is behind an edge has in it; of an edge that is not the outline's.
  void add_between(std::uint32_t from, std::uint32_t to, std::vector<std::uint32_t>& out) const {
    if (find_behind(from, to) == kNone) add_parts(from, to, out);
  }

 private:
  static std::uint64_t key(std::uint32_t from, std::uint32_t to) {
    return (std::uint64_t{from} << 32) | to;
  }
  void add_parts(std::uint32_t from, std::uint32_t to, std::vector<std::uint32_t>& out) const {
    const auto chain = chains_.find(from, to);
    std::uint32_t a = from;
    const auto go_to = [&](std::uint32_t b) {
      if (edges_.find(key(b, a)) == FlatIndex::kNone) add_parts(a, b, out);
      a = b;
    };
    for (std::size_t k = 0; k < chain.size(); ++k) {
      go_to(from < to ? chain[k] : chain[chain.size() - 1 - k]);
      out.push_back(a);
    }
    if (!chain.empty()) go_to(to);
  }

  const Hierarchy& hierarchy_;
  const EdgeChains& chains_;
  FlatIndex edges_;
};

/// What stands for a triangle next to smaller ones.
struct Replacement {
  std::size_t n_corners = 3;  ///< Of the polygon that it was made for.
  std::vector<Corners> triangles;
  std::vector<float> errors;
};

class VariableMesh {
 public:
  VariableMesh(const Hierarchy& hierarchy, const EdgeChains& chains, const PatchErrors& errors,
               const Demand& demand, int n_levels)
      : hierarchy_(hierarchy),
        end_(hierarchy.triangles_until[static_cast<std::size_t>(n_levels) - 1]),
        errors_(errors),
        demand_(demand),
        leaves_(hierarchy, chains),
        is_leaf_(hierarchy.triangles.size()) {}

  delaunay::Tin run() {
    for (std::uint32_t t = 0; t < hierarchy_.triangles_until[0]; ++t) add(t);
    refine_wanted();
    while (!is_matching()) {
      for (const std::uint32_t t : forced_) refine(t);
      forced_.clear();
      refine_wanted();
    }
    return to_tin();
  }

 private:
  void add(std::uint32_t t) {
    is_leaf_[t] = true;
    leaves_.add(t);
    fresh_.push_back(t);
    touched_.push_back(t);
  }
  void refine(std::uint32_t t) {
    is_leaf_[t] = false;
    leaves_.remove(t);
    const Corners& corner = hierarchy_.triangles[t].corner;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t behind = leaves_.find_behind(corner[i], corner[(i + 1) % 3]);
      if (behind != kNone) touched_.push_back(behind);
    }
    replacements_.erase(t);
    const auto [first, end] = hierarchy_.triangles_of(hierarchy_.triangles[t].refinement);
    for (std::uint32_t child = first; child < end; ++child) add(child);
  }
  [[nodiscard]] bool is_refined(const Hierarchy::Triangle& triangle) const {
    return triangle.refinement != kNone && hierarchy_.refinements[triangle.refinement].first < end_;
  }
  [[nodiscard]] bool wants_more(const Corners& corners, double error) const {
    const NodeFacts facts = facts_of(hierarchy_, corners, error);
    return demand_.touches(facts) && to_rank(demand_(facts)) > 0;
  }
  void refine_wanted() {
    while (!fresh_.empty()) {
      const std::uint32_t t = fresh_.back();
      fresh_.pop_back();
      const Hierarchy::Triangle& triangle = hierarchy_.triangles[t];
      if (is_refined(triangle) && wants_more(triangle.corner, error_of(triangle))) refine(t);
    }
  }
  /// With its edges: no more than the last level that has it allows, though it says so in a float
  /// that is rounded up, and more than the one that refines it. A sliver has no samples, and may be
  /// a wall.
  [[nodiscard]] double error_of(const Hierarchy::Triangle& triangle) const {
    const auto level = static_cast<std::size_t>(
        std::ranges::upper_bound(hierarchy_.triangles_until,
                                 hierarchy_.refinements[triangle.refinement].first) -
        hierarchy_.triangles_until.begin());
    return std::max(std::min(static_cast<double>(triangle.error), hierarchy_.tolerances[level - 1]),
                    std::nextafter(hierarchy_.tolerances[level], HUGE_VAL));
  }

  /// Finds replacements where they are missing; those that will not do are forced_ to be refined.
  bool is_matching() {
    std::ranges::sort(touched_);
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    for (const std::uint32_t t : touched_) {
      // What is not refined has no chain.
      if (!is_leaf_[t] || !is_refined(hierarchy_.triangles[t])) continue;
      const std::vector<std::uint32_t> border = border_of(t);
      if (border.size() == 3) continue;
      Replacement& replacement = replacements_[t];
      if (replacement.n_corners == border.size()) continue;
      replacement = {.n_corners = border.size(), .triangles = {}, .errors = {}};
      if (!replace(t, border, replacement)) forced_.push_back(t);
    }
    touched_.clear();
    return forced_.empty();
  }

  [[nodiscard]] std::vector<std::uint32_t> border_of(std::uint32_t t) const {
    std::vector<std::uint32_t> border;
    const Hierarchy::Triangle& triangle = hierarchy_.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      border.push_back(triangle.corner[i]);
      if (triangle.twin[i] != delaunay::kNoHalfEdge)
        leaves_.add_between(triangle.corner[i], triangle.corner[(i + 1) % 3], border);
    }
    return border;
  }

  bool replace(std::uint32_t t, const std::vector<std::uint32_t>& border, Replacement& out) const {
    std::vector<Place> corners;
    corners.reserve(border.size());
    for (const std::uint32_t v : border)
      corners.push_back({hierarchy_.vertices[v], hierarchy_.heights[v]});
    const auto patch = triangulate_polygon(std::move(corners));
    if (!patch) return false;
    const std::vector<double> errors = errors_.of(t, *patch);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const auto& [a, b, c] = patch->triangles[i];
      out.triangles.push_back({border[a], border[b], border[c]});
      out.errors.push_back(delaunay::to_float_above(errors[i]));
      if (errors[i] > hierarchy_.tolerances.front() ||
          wants_more(out.triangles.back(), static_cast<double>(out.errors.back())))
        return false;
    }
    return !errors.empty();
  }

  [[nodiscard]] delaunay::Tin to_tin() const {
    delaunay::Tin tin;
    for (std::uint32_t t = 0; t < is_leaf_.size(); ++t) {
      if (!is_leaf_[t]) continue;
      const auto replaced = replacements_.find(t);
      if (replaced == replacements_.end()) {
        tin.triangles.push_back(hierarchy_.triangles[t].corner);
        tin.errors.push_back(hierarchy_.triangles[t].error);
        continue;
      }
      const Replacement& by = replaced->second;
      tin.triangles.insert(tin.triangles.end(), by.triangles.begin(), by.triangles.end());
      tin.errors.insert(tin.errors.end(), by.errors.begin(), by.errors.end());
    }
    place_vertices(hierarchy_, tin);
    tin.twins = delaunay::find_twins(tin.triangles);
    return tin;
  }

  const Hierarchy& hierarchy_;
  std::uint32_t end_;  ///< Of the triangles that there are.
  const PatchErrors& errors_;
  const Demand& demand_;
  Leaves leaves_;
  std::vector<bool> is_leaf_;           ///< By triangle.
  std::vector<std::uint32_t> fresh_;    ///< Leaves that nobody has asked yet.
  std::vector<std::uint32_t> touched_;  ///< Where what is behind edges may have become another.
  std::vector<std::uint32_t> forced_;
  std::unordered_map<std::uint32_t, Replacement> replacements_;  ///< Looked up only.
};

}  // namespace

delaunay::Tin tin_of_demand(const Hierarchy& hierarchy, const EdgeChains& chains,
                            const PatchErrors& errors, const Demand& demand,
                            std::optional<int> n_levels) {
  return VariableMesh(hierarchy, chains, errors, demand, n_levels.value_or(hierarchy.n_levels()))
      .run();
}

}  // namespace lode::triangle_hierarchy
