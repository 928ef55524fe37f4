#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/build_record.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/midpoint/codes.h"
#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "lode/models/tetra_mt/midpoint/node_codes.h"
#include "lode/models/tetra_mt/midpoint/page_table.h"
#include "lode/models/tetra_mt/world_codes.h"

namespace lode::tetra_mt::midpoint {

/// What undoes a collapse, beside the links, with the first field: 28 bytes.
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

/// What undoes it of a further field: 8 bytes.
struct FieldRecord {
  std::int32_t difference;  ///< Of the ends' values.
  std::uint32_t bits;       ///< NodeCodes' of the field; bits 20 and 21: Placement::value.

  FieldRecord() = default;
  FieldRecord(std::int32_t ends, std::uint32_t facts, Place place)
      : difference(ends),
        bits(NodeCodes::without_ball(facts) | static_cast<std::uint32_t>(place) << 20) {}
  /// Without a ball.
  [[nodiscard]] std::uint32_t facts() const { return NodeCodes::without_ball(bits); }
  [[nodiscard]] Place place() const { return static_cast<Place>(bits >> 20); }
};
static_assert(sizeof(FieldRecord) == 8);

/// Labels of what a vertex splits into, the larger one first.
struct Children {
  std::uint32_t first = kNone;
  std::uint32_t second = kNone;

  friend bool operator==(const Children&, const Children&) = default;
};

/// An offset is to be added to what a vertex's code says, so that it is the mesh's bit for bit; of
/// -0, -0.
[[nodiscard]] inline double with_offset(double coded, double offset) {
  return offset == 0 && std::signbit(offset) ? offset : coded + offset;
}
/// What with_offset() takes to come from one to the other: none where they are the same bits.
[[nodiscard]] inline std::optional<double> offset_between(double coded, double exact) {
  if (std::bit_cast<std::uint64_t>(coded) == std::bit_cast<std::uint64_t>(exact)) return {};
  return exact == coded ? exact : exact - coded;
}
struct LeafOffset {
  std::array<double, 4> axes{};  ///< Position, and value of the first field.

  [[nodiscard]] Vec3d position(const Vec3d& coded) const {
    return {{with_offset(coded[0], axes[0]), with_offset(coded[1], axes[1]),
             with_offset(coded[2], axes[2])}};
  }
  [[nodiscard]] double value(double coded) const { return with_offset(coded, axes[3]); }
  friend bool operator==(const LeafOffset&, const LeafOffset&) = default;
};

/// Offsets of vertices of the mesh that their codes do not say bit for bit.
template <typename Offset>
class LeafOffsets {
 public:
  /// Leaves ascend.
  void add(std::uint32_t leaf, const Offset& offset) {
    leaves_.push_back(leaf);
    offsets_.push_back(offset);
  }
  /// None of most.
  [[nodiscard]] const Offset* find(std::uint32_t leaf) const {
    const auto at = std::ranges::lower_bound(leaves_, leaf);
    if (at == leaves_.end() || *at != leaf) return nullptr;
    return &offsets_[static_cast<std::size_t>(at - leaves_.begin())];
  }
  [[nodiscard]] std::size_t size() const { return offsets_.size(); }
  [[nodiscard]] std::span<const std::uint32_t> leaves() const { return leaves_; }
  [[nodiscard]] std::size_t n_bytes() const {
    return leaves_.size() * sizeof(std::uint32_t) + offsets_.size() * sizeof(Offset);
  }

  friend bool operator==(const LeafOffsets&, const LeafOffsets&) = default;

 private:
  std::vector<std::uint32_t> leaves_;  ///< Ascending.
  std::vector<Offset> offsets_;
};
using ExactLeaves = LeafOffsets<LeafOffset>;
using ExactValues = LeafOffsets<double>;  ///< Of a further field.

/// What of a field is in memory from the beginning.
struct ForestField {
  std::string name;
  ScalarType type = ScalarType::float64;
  std::optional<double> time{};  ///< Of a series.
  double low = 0;                ///< Of all vertices of the mesh.
  double high = 0;
  double base_error = 0;  ///< Largest |F - F'| at vertices of the mesh, on the base.
  /// Largest world error of a root; none where nodes have none.
  std::optional<double> base_world_error{};
  Scale scale{};
  NodeCodes codes{};
};

/// What of a further field is in memory once anything is asked of it; by root.
struct FieldRoots {
  std::vector<std::int32_t> codes;
  std::vector<std::uint32_t> facts;  ///< Without a ball; 0 of leaves.
  ExactValues exact;                 ///< Of leaves that are roots.

  friend bool operator==(const FieldRoots&, const FieldRoots&) = default;
};

/// What nodes and vertices have of a field but the first.
struct FurtherField {
  std::vector<FieldRecord> nodes;
  FieldRoots roots;
  ExactValues exact;
};

/// What of a hierarchy is in memory from the beginning: all but its nodes.
struct ForestHead {
  std::uint32_t n_vertices = 0;     ///< Of the mesh.
  std::uint32_t n_base_leaves = 0;  ///< Of these the first, which are in the base.
  std::uint32_t n_inner = 0;        ///< Vertices that collapses made.
  std::vector<ForestField> fields;  ///< At least one. The first lies with the nodes.
  double boundary_deviation = 0;    ///< EdgeCollapses'.
  BuildRecord record;  ///< With the tolerance of the boundary; the rest its builder says.
  Box3d box{};         ///< Of all vertices.
  std::uint64_t n_cells = 0;
  Scales scales;
  RadiusCodes radii;

  std::vector<Tetrahedron> base;  ///< By labels; with those to the vertex outside, n_labels().
  /// Places in region_ids, or, of one to the vertex outside, patch_mark() of its face. Empty where
  /// there is one region at most and no patch.
  std::vector<std::uint32_t> base_regions;
  std::uint64_t n_base_cells = 0;         ///< Without those to the vertex outside.
  std::uint32_t n_coincident_leaves = 0;  ///< Those that lie where others do, bit for bit.
  std::vector<std::uint32_t> roots;       ///< Labels of the base's vertices, ascending,
  std::vector<Code> root_codes;           ///< their codes, of the first field,
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
  std::vector<std::uint32_t> coincident_leaves;         ///< In by_place()'s order of the mesh's.
  std::vector<PageCounts> page_counts;                  ///< LabelOrder's counts of its pages,
  std::vector<std::vector<std::uint32_t>> page_levels;  ///< and their levels.
  /// By label: of a second child the parent, of a first one its sibling, which has a smaller label;
  /// kNone of what is in the base.
  std::vector<std::uint32_t> wide;
  std::vector<std::uint32_t> deep;  ///< By node: the first child, the one of the larger label.
  std::vector<NodeRecord> nodes;
  ExactLeaves exact;
  std::vector<FurtherField> further;   ///< Of field 1 on.
  std::vector<WorldPage> world_codes;  ///< By field, and by node of all; empty where it has none.
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
  /// What tells a node's ends apart, with their values of a field,
  [[nodiscard]] Code difference(std::uint32_t node, std::size_t field = 0) const;
  [[nodiscard]] Placement placement(std::uint32_t node, std::size_t field = 0) const;
  /// and what is known of it.
  [[nodiscard]] std::uint32_t facts(std::uint32_t node, std::size_t field = 0) const;
  /// Of a place in roots.
  [[nodiscard]] Code root_code(std::size_t place, std::size_t field = 0) const;
  [[nodiscard]] std::uint32_t root_word(std::size_t place, std::size_t field = 0) const;
  /// Found from the base down: one step for each vertex between.
  [[nodiscard]] Code code_of(std::uint32_t label, std::size_t field = 0) const;
  /// Of a vertex whose code is known.
  [[nodiscard]] Vec3d position(std::uint32_t label, std::span<const std::int32_t> code) const;
  [[nodiscard]] double value(std::uint32_t label, const Code& code, std::size_t field = 0) const;
  /// Regions that a node brings, as said above; empty of most.
  [[nodiscard]] std::span<const std::uint32_t> regions_of(std::uint32_t node) const;
};

/// `mesh`: what was collapsed.
[[nodiscard]] Result<Hierarchy> make_hierarchy(const TetraMesh& mesh,
                                               const EdgeCollapses& collapses, Threads threads);

}  // namespace lode::tetra_mt::midpoint
