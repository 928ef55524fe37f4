#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/models/terrain/terrain_file/source.h"

namespace lode::insertions {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A triangle of the mesh at some time. Time counts insertions: at time k the mesh has those of the
/// nodes 0 to k - 1 behind it.
struct Triangle {
  std::array<std::uint32_t, 3> corner;  ///< Vertices, turning left; of those made, the last is new.
  std::uint32_t death;                  ///< The node whose insertion removed it, or kNone.
  float error;                          ///< No sample in it errs by more; see to_coarse_above().
};

/// What samples are inserted into, and in what order. delaunay_pyramid: Delaunay, the worst sample
/// first. ternary_triangulation: triangles that are split, the worst first.
/// implicit_delaunay_pyramid: Delaunay, levels of samples that do not depend on each other.
enum class Model : std::uint8_t {
  delaunay_pyramid,
  ternary_triangulation,
  implicit_delaunay_pyramid
};

[[nodiscard]] constexpr delaunay::InsertionRule rule_of(Model model) {
  return model == Model::ternary_triangulation ? delaunay::InsertionRule::split
                                               : delaunay::InsertionRule::delaunay;
}

/// All that happened to a triangulation while samples were inserted one by one: each triangle that
/// there ever was, with the insertions that made and removed it. Of Delaunay insertions this is the
/// hypertriangulation of P. Cignoni, E. Puppo, R. Scopigno, "Representation and visualization of
/// terrain surfaces at variable resolution", Scientific Visualization '95. It is a
/// Multi-Tessellation: node k replaces triangles, as the rule says, by those round its vertex, and
/// depends on the nodes that made the former.
///
/// Of Delaunay insertions about 5.3 triangles of 20 bytes and 3.3 links of 4 bytes a node, of split
/// triangles 3 and 1, or 4 and 2 on edges.
struct History : terrain_file::Source {
  Model model = Model::delaunay_pyramid;
  /// Of an implicit pyramid the times when its levels are complete, from the coarsest finer than
  /// the base on; ascending, the last after all nodes.
  std::vector<std::uint32_t> level_ends;
  double max_error = 0;  ///< |z - z'| at every sample once all nodes are inserted.
  /// Edges of the base that all meshes have, or what nodes on them have made of them; between
  /// triangles.
  std::vector<std::array<std::uint32_t, 2>> lines;

  std::vector<delaunay::LatticePoint> vertices;  ///< Of the base, then of the nodes.
  std::vector<double> heights;                   ///< Of these, exactly.
  std::uint32_t n_base_vertices = 0;
  std::vector<Triangle> triangles;        ///< Of the base, then made by the nodes, one by one.
  std::vector<std::uint32_t> first_made;  ///< By node, and one more: its first triangle.
  std::vector<std::uint32_t> removed;  ///< By node, what it removes; first what its vertex is in.
  std::vector<std::uint32_t> first_removed;

  /// Whether each node removes a worst triangle of its time.
  [[nodiscard]] bool is_worst_first() const { return model != Model::implicit_delaunay_pyramid; }
  [[nodiscard]] std::uint32_t n_nodes() const {
    return static_cast<std::uint32_t>(vertices.size()) - n_base_vertices;
  }
  [[nodiscard]] std::uint32_t n_base_triangles() const { return first_made[0]; }
  /// The node that made a triangle, or kNone.
  [[nodiscard]] std::uint32_t birth(std::uint32_t t) const {
    return t < first_made[0] ? kNone : triangles[t].corner[2] - n_base_vertices;
  }
  [[nodiscard]] std::uint32_t vertex_of(std::uint32_t node) const { return n_base_vertices + node; }
  [[nodiscard]] std::span<const std::uint32_t> removed_by(std::uint32_t node) const {
    return std::span(removed).subspan(first_removed[node],
                                      first_removed[node + 1] - first_removed[node]);
  }
  /// The largest error of the triangles that a node removes.
  [[nodiscard]] float error_before(std::uint32_t node) const {
    float largest = 0;
    for (const std::uint32_t t : removed_by(node)) largest = std::max(largest, triangles[t].error);
    return largest;
  }
  /// What it takes, without the text of the frame.
  [[nodiscard]] std::uint64_t n_bytes() const;
};

/// By node, whether it is applied. Consistent where each one's ancestors are.
using AppliedNodes = std::vector<bool>;

/// The nodes that a mesh has: all of before a time, or a consistent set.
class NodeSet {
 public:
  explicit NodeSet(std::uint32_t time) : time_(time) {}
  explicit NodeSet(AppliedNodes applied) : is_set_(true), applied_(std::move(applied)) {}

  /// Also of kNone, which is in none.
  [[nodiscard]] bool has(std::uint32_t node) const {
    return is_set_ ? node != kNone && applied_[node] : node < time_;
  }

 private:
  bool is_set_ = false;
  std::uint32_t time_ = 0;
  AppliedNodes applied_;
};

/// When the largest error of the mesh first is no more than a tolerance: the greedy selector's mesh
/// within it, and the fewest nodes that leave no triangle beyond it. n_nodes() where that is never
/// so. Of histories that are worst first.
[[nodiscard]] std::uint32_t time_within(const History& history, double tolerance);

/// time_within() of each tolerance, which get finer.
[[nodiscard]] std::vector<std::uint32_t> times_of(const History& history,
                                                  std::span<const double> levels);

}  // namespace lode::insertions
