#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/midpoint/codes.h"

namespace lode::tetra_mt::midpoint {

/// An edge that became a vertex. That takes the slot of the vertex `kept`; `removed` is free then.
struct EdgeCollapse {
  std::uint32_t kept;     ///< The first end, for the placement,
  std::uint32_t removed;  ///< and the second.
  Placement placement;
};

/// What is known of a collapse, in the field's unit.
struct EdgeFacts {
  double error;  ///< Largest |F - F'| at samples in the tetrahedra that came of it, rounded up.
  double low;    ///< Of F at these samples, and of F' at the corners of what went and what came.
  double high;
};

/// What becomes of a mesh as its edges collapse. Vertices are slots, at first those of the mesh.
struct State {
  /// Expects one field.
  explicit State(const TetraMesh& reference);
  /// Fails when a face has more than two tetrahedra.
  [[nodiscard]] Result<void> close(Threads threads);
  /// That the closed mesh encloses now.
  [[nodiscard]] double volume() const;

  const TetraMesh& mesh;
  Scales scales;
  std::uint32_t outside;                ///< The vertex outside; all others are before it.
  std::vector<Tetrahedron> tetrahedra;  ///< By slot; those that went have no first corner.
  /// labels_of() by slot. A collapse keeps them.
  std::vector<std::uint32_t> labels;
  std::vector<std::uint32_t> first_sample;  ///< By slot: of those it covers, kNone where none.
  std::vector<std::uint32_t> next_sample;   ///< By vertex of the mesh that is no more in it.

  // By vertex.
  std::vector<Code> codes;
  std::vector<Vec3d> positions;  ///< The mesh's own, or what codes say.
  std::vector<double> values;
  std::vector<std::uint8_t> is_reference;  ///< It is still the mesh's.
  std::vector<double> deviations;  ///< How far its faces on the boundary may be off, as summed up.
  std::vector<float> errors;       ///< F - F', as shares of the range, where it is a sample.
  std::vector<float> keys;         ///< The square that the best of its own edges adds; or infinite.
  std::vector<std::uint8_t> is_there;
  std::vector<std::uint8_t> is_locked;  ///< Its link is no sphere.

  double value_scale = 0;               ///< Makes the range 1; 0 where there is none.
  double step_limit = 0;                ///< What of the boundary's moving counts as rounding,
  double deviation_limit = 0;           ///< and what that may add up to.
  std::uint64_t n_cells = 0;            ///< Without those to the vertex outside.
  std::vector<EdgeCollapse> collapses;  ///< In an order that can be done again.
  std::vector<EdgeFacts> facts;         ///< By collapse.
};

}  // namespace lode::tetra_mt::midpoint
