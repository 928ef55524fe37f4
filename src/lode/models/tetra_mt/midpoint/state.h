#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/collapse_order.h"
#include "lode/models/tetra_mt/field_quadric.h"
#include "lode/models/tetra_mt/held_samples.h"
#include "lode/models/tetra_mt/midpoint/codes.h"
#include "lode/models/tetra_mt/value_distance.h"

namespace lode::tetra_mt::midpoint {

/// An edge that became a vertex. That takes the slot of the vertex `kept`; `removed` is free then.
struct EdgeCollapse {
  std::uint32_t kept;     ///< The first end, for the placement,
  std::uint32_t removed;  ///< and the second.
  Place position;         ///< Where it lies.
};

/// What is known of a collapse, for each field, in its unit.
struct EdgeFacts {
  double error;  ///< Largest |F - F'| at samples in the tetrahedra that came of it, rounded up.
  double low;    ///< Of F at these samples, and of F' at the corners of what went and what came.
  double high;
  Place value;             ///< Whose value the new vertex has.
  double world_error = 0;  ///< CollapseFacts'; only where State says that they are found.
};

/// What becomes of a mesh as its edges collapse. Vertices are slots, at first those of the mesh.
struct State {
  /// `tolerance`: how far the boundary may move, and what lies between regions.
  State(const TetraMesh& reference, CollapseOrder collapse_order, double tolerance);
  /// Fails when a face has more than two tetrahedra.
  [[nodiscard]] Result<void> close(Threads threads);
  /// That the closed mesh encloses now.
  [[nodiscard]] double volume() const;

  const TetraMesh& mesh;
  CollapseOrder order;
  double boundary_tolerance;
  bool has_world_errors = false;  ///< EdgeFacts' are found.
  Scales scales;
  std::size_t n_fields;
  std::vector<Scale> field_scales;      ///< By field.
  std::uint32_t outside;                ///< The vertex outside; all others are before it.
  std::vector<Tetrahedron> tetrahedra;  ///< By slot; those that went have no first corner.
  /// labels_of() by slot. A collapse keeps them.
  std::vector<std::uint32_t> labels;
  /// By slot: how far any face of it between regions or on the boundary is from the reference's,
  /// or they from it, at most, where the tetrahedron across says no more.
  std::vector<double> deviations;
  std::vector<std::uint32_t> first_sample;  ///< By slot: of those it covers, kNone where none.
  std::vector<CornerSets> corner_sets;      ///< By slot: of the same.
  std::vector<std::uint32_t> next_sample;   ///< By vertex of the mesh that is no more in it,
  std::vector<CornerBits> sample_corners;   ///< and where it lies in what covers it.

  // By vertex; values, their codes and errors by field, too.
  std::vector<PositionCode> codes;
  std::vector<std::int32_t> value_codes;
  std::vector<Vec3d> positions;            ///< The mesh's own, or what codes say.
  std::vector<double> values;              ///< Likewise.
  std::vector<std::uint8_t> is_reference;  ///< It is still the mesh's.
  std::vector<float> errors;  ///< F - F', as shares of the range, where it is a sample.
  std::vector<float> keys;    ///< The square that the best of its own edges adds; or infinite.
  std::vector<std::uint8_t> is_there;
  std::vector<std::uint8_t> is_locked;  ///< Its link is no sphere.

  std::vector<double> value_units;  ///< By field: makes its range 1; 0 where there is none.
  std::vector<float> distances;     ///< By vertex and field: of a sample how far F' has the value,
  std::vector<FieldQuadric> quadrics;   ///< and likewise; where they are the order.
  Vec3d centre;                         ///< Of the mesh's box.
  double size = 1;                      ///< Its diagonal; 1 where it has none.
  double step_limit = 0;                ///< What of the boundary's moving counts as rounding,
  double deviation_limit = 0;           ///< and what that may add up to.
  std::uint64_t n_cells = 0;            ///< Without those to the vertex outside.
  std::vector<EdgeCollapse> collapses;  ///< In an order that can be done again.
  std::vector<EdgeFacts> facts;         ///< By collapse and field.

  /// Of the mesh that was read.
  [[nodiscard]] double sample(std::uint32_t vertex, std::size_t field) const {
    return mesh.fields[field].values[vertex];
  }
  /// BuildState's.
  [[nodiscard]] Range same_values(std::uint32_t vertex, std::size_t field) const {
    const double slack = value_units[field] > 0 ? kSameValue / value_units[field] : 0;
    return {sample(vertex, field) - slack, sample(vertex, field) + slack};
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

 private:
  void take_fields();
};

}  // namespace lode::tetra_mt::midpoint
