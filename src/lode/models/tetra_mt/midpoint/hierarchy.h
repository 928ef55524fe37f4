#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/midpoint/codes.h"
#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "lode/models/tetra_mt/midpoint/node_codes.h"

namespace lode::tetra_mt::midpoint {

/// What undoes a collapse, beside the links: 28 bytes.
struct NodeRecord {
  Code difference;  ///< Of the ends: x, y, z and value, the second's less the first's.
  /// Bit i: whether the i-th tetrahedron round the vertex is the second end's, in the order of
  /// their other corners' labels. Bits 60 and 61: Placement::position; 62 and 63: value.
  std::array<std::uint32_t, 2> mask;  ///< Low half first.
  std::uint32_t facts;                ///< NodeCodes.
};
static_assert(sizeof(NodeRecord) == 28 && alignof(NodeRecord) == 4);

/// Vertices of the mesh that their codes do not say bit for bit.
class ExactLeaves {
 public:
  struct Vertex {
    Vec3d position;
    double value;
  };

  void add(std::uint32_t leaf, const Vertex& vertex);
  void set_size(std::uint32_t n_leaves) { is_here_.resize((n_leaves + 63) / 64); }
  [[nodiscard]] bool has(std::uint32_t leaf) const {
    return (is_here_[leaf / 64] >> leaf % 64 & 1) != 0;
  }
  /// Expects it there.
  [[nodiscard]] const Vertex& of(std::uint32_t leaf) const;
  [[nodiscard]] std::size_t size() const { return vertices_.size(); }
  [[nodiscard]] std::size_t n_bytes() const;

 private:
  std::vector<std::uint64_t> is_here_;  ///< A bit a leaf.
  std::vector<std::uint32_t> leaves_;   ///< Ascending.
  std::vector<Vertex> vertices_;
};

/// A mesh of tetrahedra as a Multi-Tessellation of collapses of edges to their midpoints, in the
/// compact form of the paper's section 5: a forest of vertices, and for each inner one where its
/// ends lie and which of the tetrahedra round it belong to which. Labels: the mesh's vertices in
/// its order, then those that collapses made, in theirs; node k splits vertex n_vertices + k. So
/// labels fall along every split, and tell the order among nodes (El-Sana, Varshney 1999): a vertex
/// may be split where all beside it have smaller labels. The vertex outside has the next label, but
/// counts as smaller than all.
struct Hierarchy {
  std::uint32_t n_vertices = 0;
  std::string field;
  ScalarType type = ScalarType::float64;
  double low = 0;  ///< Of the field.
  double high = 0;
  double base_error = 0;          ///< Largest |F - F'| at vertices of the mesh, on the base.
  double boundary_deviation = 0;  ///< EdgeCollapses'.
  Box3d box{};                    ///< Of all vertices.
  std::uint64_t n_cells = 0;
  Scales scales;
  NodeCodes codes;

  /// By label: of a second child the parent, of a first one its sibling, which has a smaller label;
  /// kNone of what is in the base.
  std::vector<std::uint32_t> wide;
  std::vector<std::uint32_t> deep;  ///< By node: the first child, the one of the larger label.
  std::vector<NodeRecord> nodes;
  ExactLeaves exact;

  std::vector<Tetrahedron> base;  ///< By labels; with those to the vertex outside, n_labels().
  /// Places in region_ids, or, of one to the vertex outside, patch_mark() of its face. Empty where
  /// there is one region at most and no patch.
  std::vector<std::uint32_t> base_regions;
  std::uint64_t n_base_cells = 0;        ///< Without those to the vertex outside.
  std::vector<std::uint32_t> roots;      ///< Labels of the base's vertices, ascending,
  std::vector<Code> root_codes;          ///< and their codes.
  std::vector<std::int64_t> region_ids;  ///< The mesh's.
  std::vector<BoundaryPatch> patches;    ///< Likewise.
  /// Nodes whose tetrahedra are not all of one region, and those outside of one patch, ascending,
  /// and where what base_regions says of those that they bring between both ends begins, in the
  /// order of the edges' labels.
  std::vector<std::uint32_t> mixed_nodes;
  std::vector<std::uint64_t> mixed_begins;
  std::vector<std::uint32_t> mixed_regions;

  [[nodiscard]] std::uint32_t n_nodes() const { return static_cast<std::uint32_t>(deep.size()); }
  [[nodiscard]] std::uint32_t n_labels() const { return static_cast<std::uint32_t>(wide.size()); }
  [[nodiscard]] std::uint32_t outside() const { return n_labels(); }
  [[nodiscard]] bool is_leaf(std::uint32_t label) const { return label < n_vertices; }
  /// The vertex that splits into it and another; kNone of the base's.
  [[nodiscard]] std::uint32_t parent(std::uint32_t label) const {
    const std::uint32_t at = wide[label];
    return at == kNone || at > label ? at : wide[at];
  }
  struct Children {
    std::uint32_t first;
    std::uint32_t second;
  };
  [[nodiscard]] Children children(std::uint32_t node) const {
    return {deep[node], wide[deep[node]]};
  }
  [[nodiscard]] Placement placement(std::uint32_t node) const {
    const std::uint32_t bits = nodes[node].mask[1] >> 28;
    return {static_cast<Place>(bits & 3), static_cast<Place>(bits >> 2)};
  }
  [[nodiscard]] bool is_second(std::uint32_t node, std::size_t tetrahedron) const {
    return (nodes[node].mask[tetrahedron / 32] >> tetrahedron % 32 & 1) != 0;
  }
  /// Found from the base down: one step for each vertex between.
  [[nodiscard]] Code code_of(std::uint32_t label) const;
  /// Of a vertex whose code is known.
  [[nodiscard]] Vec3d position(std::uint32_t label, const Code& code) const {
    return is_leaf(label) && exact.has(label) ? exact.of(label).position : scales.position(code);
  }
  [[nodiscard]] double value(std::uint32_t label, const Code& code) const {
    return is_leaf(label) && exact.has(label) ? exact.of(label).value : scales.value(code);
  }
  /// Regions that a node brings, as said above; empty of most.
  [[nodiscard]] std::span<const std::uint32_t> regions_of(std::uint32_t node) const;

  /// What the paper counts: links, offsets, values, masks and facts of the forest.
  [[nodiscard]] std::uint64_t n_bytes_of_nodes() const;
  /// What it does not: the base, exact vertices, regions.
  [[nodiscard]] std::uint64_t n_bytes_beside() const;
};

/// `mesh`: what was collapsed.
[[nodiscard]] Result<Hierarchy> make_hierarchy(const TetraMesh& mesh,
                                               const EdgeCollapses& collapses, Threads threads);

}  // namespace lode::tetra_mt::midpoint
