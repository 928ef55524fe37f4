#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/collapse_order.h"
#include "lode/models/tetra_mt/collapse_stars.h"
#include "lode/models/tetra_mt/field_quadric.h"
#include "lode/models/tetra_mt/held_samples.h"
#include "lode/models/tetra_mt/value_distance.h"

namespace lode::tetra_mt {

/// One collapse: `removed` went into `kept`.
struct Collapse {
  std::uint32_t removed;
  std::uint32_t kept;
};

/// What is known of a collapse, for each field, in its unit.
struct CollapseFacts {
  /// Largest |F - F'| at samples in the tetrahedra that came of it, rounded up.
  double error;
  double low;  ///< Of F at these samples, and at the tetrahedra's corners.
  double high;
  /// Largest distance_in_cells() of a sample from where these tetrahedra have its value, in the
  /// mesh's unit: the paper's space error, an estimate. Only where CollapseRules ask for it.
  double world_error = 0;
};

/// By how much the boundary, and what lies between regions, may move.
struct BoundaryLimits {
  double step = 0;   ///< In a collapse that is not along planes.
  double total = 0;  ///< In all.
};

/// What becomes of a mesh as its edges collapse.
struct BuildState {
  BuildState(const TetraMesh& reference, CollapseOrder order);
  /// Closes the mesh. Fails when a face has more than two tetrahedra.
  [[nodiscard]] Result<void> close(Threads threads);
  /// `tolerance`: what is asked for. Steps of some roundings of narrow positions are none; and all
  /// may add up to more of them, or to a millionth of the mesh's size.
  void set_limits(double tolerance);
  /// That the closed mesh encloses now.
  [[nodiscard]] double volume() const;
  void follow_boundary();

  const TetraMesh& mesh;
  std::uint32_t outside;                ///< The vertex outside; all others are before it.
  std::vector<Tetrahedron> tetrahedra;  ///< By slot; those that went have no first corner.
  /// labels_of() by slot. A collapse keeps them.
  std::vector<std::uint32_t> labels;
  /// By slot: how far any face of it between regions or on the boundary is from the reference's,
  /// or they from it, at most, where the tetrahedron across says no more.
  std::vector<float> deviations;
  std::vector<std::uint32_t> makers;  ///< By slot: the vertex whose collapse made it, or kNone.
  BoundaryLimits limits;
  // Where a tolerance lets the boundary move; else empty.
  std::vector<std::uint32_t> first_on_boundary;  ///< By slot outside: of vertices that went there.
  std::vector<std::uint32_t> next_on_boundary;   ///< By removed vertex.
  std::vector<float> boundary_edges;             ///< By vertex: the reference's longest at it.
  std::vector<std::uint32_t> first_sample;       ///< By slot: of those it covers, kNone where none.
  std::vector<CornerSets> corner_sets;           ///< By slot: of the same.
  std::vector<std::uint32_t> next_sample;        ///< By removed vertex: the next one there,
  std::vector<CornerBits> sample_corners;        ///< and where it lies there.
  std::size_t n_fields;
  std::vector<double> scales;    ///< By field: what makes its range 1; 0 where it has none.
  std::vector<float> errors;     ///< F - F' of removed vertices, by vertex and field, so scaled.
  std::vector<float> distances;  ///< Likewise how far F' has the value; where these are the order.
  std::vector<FieldQuadric> quadrics;   ///< By vertex and field; where they are the order.
  Vec3d centre;                         ///< Of the mesh's box.
  double size = 1;                      ///< Its diagonal; 1 where it has none.
  std::vector<float> keys;              ///< By vertex: what its going adds, as known; or infinite.
  std::vector<std::uint8_t> is_there;   ///< By vertex, as long as it is not removed.
  std::vector<std::uint8_t> is_locked;  ///< By vertex: its link is no sphere.
  /// By vertex: extrema of the reference, where these are to stay; else empty.
  std::vector<std::uint8_t> stays;
  std::vector<Collapse> collapses;   ///< In an order that can be done again.
  std::vector<CollapseFacts> facts;  ///< By collapse and field.
  std::vector<CollapseStars> stars;  ///< Of the collapses, in pieces.
  std::uint64_t n_cells = 0;         ///< Without those to the vertex outside.

  /// Those that count as a vertex's where distances are asked for.
  [[nodiscard]] Range same_values(std::uint32_t vertex, std::size_t field) const {
    const double slack = scales[field] > 0 ? kSameValue / scales[field] : 0;
    return {value(vertex, field) - slack, value(vertex, field) + slack};
  }
  [[nodiscard]] double value(std::uint32_t vertex, std::size_t field) const {
    return mesh.fields[field].values[vertex];
  }
  [[nodiscard]] std::span<float> errors_of(std::uint32_t vertex) {
    return std::span(errors).subspan(vertex * n_fields, n_fields);
  }
  [[nodiscard]] std::span<float> distances_of(std::uint32_t vertex) {
    return std::span(distances).subspan(vertex * n_fields, n_fields);
  }
  [[nodiscard]] std::span<FieldQuadric> quadrics_of(std::uint32_t vertex) {
    return std::span(quadrics).subspan(vertex * n_fields, n_fields);
  }
};

}  // namespace lode::tetra_mt
