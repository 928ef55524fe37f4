// L. De Floriani, E. Puppo, "Hierarchical triangulation for multiresolution surface description",
// ACM Transactions on Graphics 14 (1995): variable resolution; that patches are measured, and
// refined where they err, is ours.
#include "lode/models/terrain/hierarchical_delaunay/variable.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "lode/core/flat_index.h"
#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/hierarchical_delaunay/polygon.h"
#include "lode/refine/surface_facts.h"

namespace lode::hierarchical_delaunay {
namespace {

using triangle_hierarchy::Hierarchy;
using triangle_hierarchy::kNone;

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
  /// The vertices that what is behind an edge has in it.
  void add_between(std::uint32_t from, std::uint32_t to, std::vector<std::uint32_t>& out) const {
    if (has_behind(from, to) || !has_parts_behind(from, to)) return;
    visit_parts(from, to, [&](std::uint32_t a, std::uint32_t b) {
      add_between(a, b, out);
      if (b != to) out.push_back(b);
      return false;
    });
  }

 private:
  static std::uint64_t key(std::uint32_t from, std::uint32_t to) {
    return (std::uint64_t{from} << 32) | to;
  }
  [[nodiscard]] bool has_behind(std::uint32_t from, std::uint32_t to) const {
    return edges_.find(key(to, from)) != FlatIndex::kNone;
  }
  /// Whether that holds for some part of the edge, which is not so where the other triangle is the
  /// larger one, or there is none.
  [[nodiscard]] bool has_parts_behind(std::uint32_t from, std::uint32_t to) const {
    return visit_parts(from, to, [&](std::uint32_t a, std::uint32_t b) {
      return has_behind(a, b) || has_parts_behind(a, b);
    });
  }
  /// Until visit(a, b) is true of a part, which it returns.
  template <typename Visit>
  bool visit_parts(std::uint32_t from, std::uint32_t to, const Visit& visit) const {
    const auto chain = chains_.find(from, to);
    if (chain.empty()) return false;
    std::uint32_t a = from;
    for (std::size_t k = 0; k < chain.size(); ++k) {
      const std::uint32_t b = from < to ? chain[k] : chain[chain.size() - 1 - k];
      if (visit(a, b)) return true;
      a = b;
    }
    return visit(a, to);
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
  VariableMesh(const Hierarchy& hierarchy, const EdgeChains& chains, const FineGrid& grid,
               const Demand& demand)
      : hierarchy_(hierarchy),
        grid_(grid),
        demand_(demand),
        leaves_(hierarchy, chains),
        is_leaf_(hierarchy.triangles.size()) {}

  Result<delaunay::Tin> run() {
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
  }
  void refine(std::uint32_t t) {
    is_leaf_[t] = false;
    leaves_.remove(t);
    replacements_.erase(t);
    const auto [first, end] = hierarchy_.triangles_of(hierarchy_.triangles[t].refinement);
    for (std::uint32_t child = first; child < end; ++child) add(child);
  }
  [[nodiscard]] bool wants_more(const Corners& corners, float error) const {
    const NodeFacts facts = facts_of(hierarchy_, corners, static_cast<double>(error));
    return demand_.touches(facts) && to_rank(demand_(facts)) > 0;
  }
  void refine_wanted() {
    while (!fresh_.empty()) {
      const std::uint32_t t = fresh_.back();
      fresh_.pop_back();
      const Hierarchy::Triangle& triangle = hierarchy_.triangles[t];
      if (triangle.refinement != kNone && wants_more(triangle.corner, triangle.error)) refine(t);
    }
  }

  /// Finds replacements where they are missing; those that will not do are forced_ to be refined.
  bool is_matching() {
    for (std::uint32_t t = 0; t < is_leaf_.size(); ++t) {
      // What is not refined has no chain.
      if (!is_leaf_[t] || hierarchy_.triangles[t].refinement == kNone) continue;
      const std::vector<std::uint32_t> border = border_of(t);
      if (border.size() == 3) continue;
      Replacement& replacement = replacements_[t];
      if (replacement.n_corners == border.size()) continue;
      replacement = {.n_corners = border.size(), .triangles = {}, .errors = {}};
      if (!replace(border, replacement)) forced_.push_back(t);
    }
    return forced_.empty();
  }

  [[nodiscard]] std::vector<std::uint32_t> border_of(std::uint32_t t) const {
    std::vector<std::uint32_t> border;
    const Corners& corner = hierarchy_.triangles[t].corner;
    for (std::size_t i = 0; i < 3; ++i) {
      border.push_back(corner[i]);
      leaves_.add_between(corner[i], corner[(i + 1) % 3], border);
    }
    return border;
  }

  bool replace(const std::vector<std::uint32_t>& border, Replacement& out) const {
    std::vector<Place> corners;
    corners.reserve(border.size());
    for (const std::uint32_t v : border)
      corners.push_back({hierarchy_.vertices[v], hierarchy_.heights[v]});
    const auto patch = triangulate_polygon(std::move(corners));
    if (!patch) return false;
    for (const Corners& places : patch->triangles) {
      const auto& [a, b, c] = places;
      out.triangles.push_back({border[a], border[b], border[c]});
      double error = measure_samples(grid_, {patch->places[a], patch->places[b], patch->places[c]},
                                     triangle_hierarchy::kNoEdges)
                         .closed;
      if (wants_more(out.triangles.back(), stated(error))) return false;
      error = std::max(error, error_inside(*patch, places));
      out.errors.push_back(stated(error));
      if (wants_more(out.triangles.back(), out.errors.back())) return false;
    }
    return true;
  }
  [[nodiscard]] float stated(double error) const {
    return delaunay::to_float_above(error + grid_.rounding());
  }

  /// Of a triangle's edges that are none of the polygon's, where they cross columns and rows: a
  /// sliver between vertices of a chain has no samples, and may be a wall.
  template <typename Patch>
  [[nodiscard]] double error_inside(const Patch& patch, const Corners& places) const {
    double error = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = places[i];
      const std::uint32_t b = places[(i + 1) % 3];
      if ((a + 1) % patch.places.size() != b)
        error = std::max(error, worst_crossing(grid_, patch.places[a], patch.places[b]).error);
    }
    return error;
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
  const FineGrid& grid_;
  const Demand& demand_;
  Leaves leaves_;
  std::vector<bool> is_leaf_;         ///< By triangle.
  std::vector<std::uint32_t> fresh_;  ///< Leaves that nobody has asked yet.
  std::vector<std::uint32_t> forced_;
  std::unordered_map<std::uint32_t, Replacement> replacements_;  ///< Looked up only.
};

}  // namespace

Result<delaunay::Tin> tin_of_demand(const Hierarchy& hierarchy, const EdgeChains& chains,
                                    const FineGrid& grid, const Demand& demand) {
  const HeightFrame& frame = hierarchy.frame;
  if (grid.frame().n_columns != frame.n_columns || grid.frame().n_rows != frame.n_rows ||
      grid.bits() != hierarchy.bits)
    return fail("expected the raster of the model, of {} x {} samples, got {} x {}",
                frame.n_columns, frame.n_rows, grid.frame().n_columns, grid.frame().n_rows);
  return VariableMesh(hierarchy, chains, grid, demand).run();
}

}  // namespace lode::hierarchical_delaunay
