#pragma once

#include <array>
#include <cmath>
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
#include "lode/models/tetra_mt/midpoint/page_table.h"

namespace lode::tetra_mt::midpoint {

/// What undoes a collapse, beside the links: 28 bytes.
struct NodeRecord {
  Code difference;  ///< Of the ends: x, y, z and value, the second's less the first's.
  /// Bit i: whether the i-th tetrahedron round the vertex is the second end's, in the order of
  /// their other corners' labels. Bits 60 and 61: Placement::position; 62 and 63: value.
  std::array<std::uint32_t, 2> mask;  ///< Low half first.
  std::uint32_t facts;                ///< NodeCodes.

  [[nodiscard]] bool is_second(std::size_t tetrahedron) const {
    return (mask[tetrahedron / 32] >> tetrahedron % 32 & 1) != 0;
  }
  [[nodiscard]] Placement placement() const {
    const std::uint32_t bits = mask[1] >> 28;
    return {static_cast<Place>(bits & 3), static_cast<Place>(bits >> 2)};
  }
  friend bool operator==(const NodeRecord&, const NodeRecord&) = default;
};
static_assert(sizeof(NodeRecord) == 28 && alignof(NodeRecord) == 4);

/// Labels of what a vertex splits into, the larger one first.
struct Children {
  std::uint32_t first = kNone;
  std::uint32_t second = kNone;

  friend bool operator==(const Children&, const Children&) = default;
};

/// What is to be added to what a vertex's code says, so that it is the mesh's bit for bit; of -0,
/// -0.
struct LeafOffset {
  std::array<double, 4> axes{};  ///< Position and value.

  [[nodiscard]] static double added(double coded, double offset) {
    return offset == 0 && std::signbit(offset) ? offset : coded + offset;
  }
  [[nodiscard]] Vec3d position(const Vec3d& coded) const {
    return {{added(coded[0], axes[0]), added(coded[1], axes[1]), added(coded[2], axes[2])}};
  }
  [[nodiscard]] double value(double coded) const { return added(coded, axes[3]); }
  friend bool operator==(const LeafOffset&, const LeafOffset&) = default;
};

/// Of vertices of the mesh that their codes do not say bit for bit.
class ExactLeaves {
 public:
  /// Leaves ascend.
  void add(std::uint32_t leaf, const LeafOffset& offset) {
    leaves_.push_back(leaf);
    offsets_.push_back(offset);
  }
  /// None of most.
  [[nodiscard]] const LeafOffset* find(std::uint32_t leaf) const;
  [[nodiscard]] std::size_t size() const { return offsets_.size(); }
  [[nodiscard]] std::span<const std::uint32_t> leaves() const { return leaves_; }
  [[nodiscard]] std::size_t n_bytes() const {
    return leaves_.size() * sizeof(std::uint32_t) + offsets_.size() * sizeof(LeafOffset);
  }

  friend bool operator==(const ExactLeaves&, const ExactLeaves&) = default;

 private:
  std::vector<std::uint32_t> leaves_;  ///< Ascending.
  std::vector<LeafOffset> offsets_;
};

/// What of a hierarchy is in memory from the beginning: all but its nodes.
struct ForestHead {
  std::uint32_t n_vertices = 0;     ///< Of the mesh.
  std::uint32_t n_base_leaves = 0;  ///< Of these the first, which are in the base.
  std::uint32_t n_inner = 0;        ///< Vertices that collapses made.
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

  std::vector<Tetrahedron> base;  ///< By labels; with those to the vertex outside, n_labels().
  /// Places in region_ids, or, of one to the vertex outside, patch_mark() of its face. Empty where
  /// there is one region at most and no patch.
  std::vector<std::uint32_t> base_regions;
  std::uint64_t n_base_cells = 0;         ///< Without those to the vertex outside.
  std::vector<std::uint32_t> roots;       ///< Labels of the base's vertices, ascending,
  std::vector<Code> root_codes;           ///< their codes,
  std::vector<std::uint32_t> root_facts;  ///< and facts, 0 of leaves.
  ExactLeaves base_exact;                 ///< Of leaves that are roots.
  std::vector<std::int64_t> region_ids;   ///< The mesh's.
  std::vector<std::string> region_names;  ///< TetraMesh's.
  std::vector<BoundaryPatch> patches;     ///< Likewise.
  PageTable pages;

  [[nodiscard]] std::uint32_t n_nodes() const { return n_inner; }
  [[nodiscard]] std::uint32_t n_labels() const { return n_vertices + n_inner; }
  [[nodiscard]] std::uint32_t outside() const { return n_labels(); }
  [[nodiscard]] bool is_leaf(std::uint32_t label) const { return label < n_vertices; }
  [[nodiscard]] bool has_regions() const { return !patches.empty() || region_ids.size() > 1; }
  /// Place in roots; expects one there.
  [[nodiscard]] std::size_t place_of_root(std::uint32_t label) const;
};

/// A mesh of tetrahedra as a Multi-Tessellation of collapses of edges to their midpoints, in the
/// compact form of the paper's section 5: a forest of vertices, and for each inner one where its
/// ends lie and which of the tetrahedra round it belong to which. Labels: the mesh's vertices, the
/// *leaves*, then those that collapses made; node k splits vertex n_vertices + k. A label is above
/// those of all vertices beside it when it was made, so that labels tell the order among nodes
/// (El-Sana, Varshney 1999): a vertex may be split where all beside it have smaller ones. Which of
/// such orders it is follows from the pages (label_order.h). The vertex outside has the next label,
/// but counts as smaller than all.
struct Hierarchy : ForestHead {
  std::vector<std::uint32_t> mesh_vertices;             ///< By leaf: its number in the mesh.
  std::vector<PageCounts> page_counts;                  ///< LabelOrder's counts of its pages,
  std::vector<std::vector<std::uint32_t>> page_levels;  ///< and their levels.
  /// By label: of a second child the parent, of a first one its sibling, which has a smaller label;
  /// kNone of what is in the base.
  std::vector<std::uint32_t> wide;
  std::vector<std::uint32_t> deep;  ///< By node: the first child, the one of the larger label.
  std::vector<NodeRecord> nodes;
  ExactLeaves exact;
  /// Nodes whose tetrahedra are not all of one region, and those outside of one patch, ascending,
  /// and where what base_regions says of those that they bring between both ends begins, in the
  /// order of the edges' labels.
  std::vector<std::uint32_t> mixed_nodes;
  std::vector<std::uint64_t> mixed_begins;
  std::vector<std::uint32_t> mixed_regions;

  /// The vertex that splits into it and another; kNone of the base's.
  [[nodiscard]] std::uint32_t parent(std::uint32_t label) const {
    const std::uint32_t at = wide[label];
    return at == kNone || at > label ? at : wide[at];
  }
  [[nodiscard]] Children children(std::uint32_t node) const {
    return {deep[node], wide[deep[node]]};
  }
  /// Found from the base down: one step for each vertex between.
  [[nodiscard]] Code code_of(std::uint32_t label) const;
  /// Of a vertex whose code is known.
  [[nodiscard]] Vec3d position(std::uint32_t label, const Code& code) const {
    const LeafOffset* const offset = is_leaf(label) ? exact.find(label) : nullptr;
    const Vec3d coded = scales.position(code);
    return offset != nullptr ? offset->position(coded) : coded;
  }
  [[nodiscard]] double value(std::uint32_t label, const Code& code) const {
    const LeafOffset* const offset = is_leaf(label) ? exact.find(label) : nullptr;
    const double coded = scales.value(code);
    return offset != nullptr ? offset->value(coded) : coded;
  }
  /// Regions that a node brings, as said above; empty of most.
  [[nodiscard]] std::span<const std::uint32_t> regions_of(std::uint32_t node) const;
};

/// `mesh`: what was collapsed.
[[nodiscard]] Result<Hierarchy> make_hierarchy(const TetraMesh& mesh,
                                               const EdgeCollapses& collapses, Threads threads);

}  // namespace lode::tetra_mt::midpoint
