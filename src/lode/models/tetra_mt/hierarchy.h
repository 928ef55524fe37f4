#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/build_record.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/half_edge.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// A mesh of tetrahedra as a Multi-Tessellation of half-edge collapses, with the order of regions:
/// a node replaces the tetrahedra that its collapse made, and depends on the nodes that must be
/// applied for these to be there, and on no others. Nodes are numbered as order_nodes() says; node
/// k brings vertex n_base_vertices + k.
///
/// No tetrahedra are stored but the base's. What a node replaces are the tetrahedra round its
/// target that it has made: a cut knows of each tetrahedron whose it is. What comes are those
/// tetrahedra with the new vertex in the target's place, and one for each edge of the outline of
/// their faces across from the target. Whose these are is stored: those with a face across first,
/// then those with an edge, each by face_key(). A tetrahedron whose corner changes keeps its
/// region or patch; those of edges have what those replaced have, or it is stored.
struct Hierarchy {
  std::uint32_t n_base_vertices = 0;
  std::vector<Vec3d> positions;   ///< By vertex.
  std::vector<MeshField> fields;  ///< Of one component, by vertex.
  std::optional<double> time{};   ///< Of all of them, of a series.
  std::vector<Tetrahedron> base;  ///< With those to the vertex outside, number positions.size().
  std::vector<std::uint32_t> base_makers;  ///< By tetrahedron of the base: its node, or kNone.
  std::uint64_t n_base_cells = 0;          ///< Without those to the vertex outside.
  double boundary_deviation = 0;           ///< HalfEdgeCollapses': of the base, and so of any cut.
  BuildRecord record;                      ///< Whoever builds a file of it says.
  bool has_errors_everywhere = false;     ///< HalfEdgeCollapses': facts' errors hold at all points.
  bool has_world_errors = false;          ///< Likewise: else facts' are infinite.
  std::vector<std::int64_t> region_ids;   ///< The mesh's.
  std::vector<std::string> region_names;  ///< TetraMesh's.
  std::vector<BoundaryPatch> patches;     ///< Likewise.
  /// By tetrahedron of the base: places in region_ids, or, of one to the vertex outside,
  /// patch_mark() of its face. Empty where there is one region at most and no patch.
  std::vector<std::uint32_t> base_regions;

  std::vector<std::uint32_t> mesh_vertices;  ///< By vertex: the mesh's that it is.
  std::vector<std::uint32_t> order;      ///< Nodes as they may be applied: the collapses reversed.
  std::vector<std::uint32_t> targets;    ///< By node: the vertex that its own went into.
  std::vector<StoredFacts> facts;        ///< By node and field: nested along discovery.
  std::vector<double> range_references;  ///< By field: what facts' ranges are above.
  std::vector<std::uint32_t> boxes;      ///< By node: BoxCodes of what it discovers.
  std::vector<std::uint64_t> child_begins;  ///< By node, and one more.
  std::vector<std::uint32_t> children;      ///< Ascending, each node's.
  std::vector<std::uint64_t> parent_begins;
  std::vector<std::uint32_t> parents;      ///< Likewise.
  std::vector<std::uint32_t> discoverers;  ///< By node: its last parent in `order`, or kNone.
  std::vector<std::uint64_t> maker_begins;
  /// By node and tetrahedron that it brings: which of its children has made it, or kReference.
  std::vector<std::uint8_t> makers;

  std::vector<std::uint64_t> region_begins;
  /// By node and tetrahedron that it brings with an edge, in the order of makers: its region or
  /// patch, as base_regions says it. None of nodes whose tetrahedra are all of the one region, and
  /// those outside of the one patch, of what they replace.
  std::vector<std::uint32_t> regions;
  /// By node: which regions the tetrahedra have that it brings, and those of all that it discovers;
  /// region_bit()s. Empty where there is one region at most.
  std::vector<std::uint64_t> region_masks;

  static constexpr std::uint8_t kReference = 0xFF;

  [[nodiscard]] std::uint32_t n_nodes() const { return static_cast<std::uint32_t>(targets.size()); }
  [[nodiscard]] std::uint32_t outside() const {
    return static_cast<std::uint32_t>(positions.size());
  }
  [[nodiscard]] std::span<const std::uint32_t> children_of(std::uint32_t node) const {
    return std::span(children).subspan(child_begins[node],
                                       child_begins[node + 1] - child_begins[node]);
  }
  [[nodiscard]] std::span<const std::uint32_t> parents_of(std::uint32_t node) const {
    return std::span(parents).subspan(parent_begins[node],
                                      parent_begins[node + 1] - parent_begins[node]);
  }
  [[nodiscard]] std::span<const std::uint32_t> regions_of(std::uint32_t node) const {
    return std::span(regions).subspan(region_begins[node],
                                      region_begins[node + 1] - region_begins[node]);
  }
  [[nodiscard]] std::span<const std::uint8_t> makers_of(std::uint32_t node) const {
    return std::span(makers).subspan(maker_begins[node],
                                     maker_begins[node + 1] - maker_begins[node]);
  }
};

/// A face, or an edge and kNone, whatever the order of its corners; ascending keys keep together
/// what has a vertex in common.
struct FaceKey {
  std::uint64_t first;  ///< The smallest corner, and the next one.
  std::uint32_t last;

  friend auto operator<=>(const FaceKey&, const FaceKey&) = default;
};
[[nodiscard]] inline FaceKey face_key(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::uint32_t low = std::min(a, b);
  const std::uint32_t high = std::max(a, b);
  const std::uint32_t middle = std::min(high, std::max(low, c));
  return {std::uint64_t{std::min(low, c)} << 32 | middle, std::max(high, c)};
}

/// `mesh`: what was collapsed.
[[nodiscard]] Result<Hierarchy> make_hierarchy(const TetraMesh& mesh,
                                               const HalfEdgeCollapses& collapses, Threads threads);

}  // namespace lode::tetra_mt
