#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/model.h"

namespace lode {

/// All vertices of a hierarchy, as verification looks at them.
struct TetraVertices {
  std::vector<Vec3d> positions;
  std::vector<double> values;          ///< Of one field.
  std::vector<std::uint32_t> samples;  ///< Those of cells of the reference mesh.
  std::size_t n_of_mesh = 0;           ///< The first ones; others are where some of them went.
  bool has_narrow_positions = false;
  double size = 0;             ///< Of the box round all of the mesh, along its diagonal.
  double farthest = 0;         ///< From the origin.
  bool has_stated_box = true;  ///< That box is the one that the hierarchy says.

  /// Of a hierarchy, without values.
  explicit TetraVertices(const tetra_mt::PackedHierarchy& hierarchy);
  /// Of midpoints, by labels, without values.
  explicit TetraVertices(const tetra_mt::midpoint::Forest& forest);
  void take_values(const tetra_mt::PackedHierarchy& hierarchy, std::size_t field);
  void take_values(const tetra_mt::midpoint::Forest& forest, std::size_t field);
  /// How far the boundary of any cut may be from the reference's: what docs/models/tetra_mt.md
  /// says of rounding, or what the hierarchy says, where it was built with a tolerance.
  [[nodiscard]] double boundary_allowance() const;
  /// Whether it may move by more than rounding.
  [[nodiscard]] bool has_moving_boundary() const {
    return boundary_deviation_ > rounding_allowance();
  }

 private:
  [[nodiscard]] double rounding_allowance() const;

  /// Of the first n, which are the mesh's.
  void find_extent(std::size_t n, const Box3d& stated);

  double boundary_deviation_ = 0;  ///< The hierarchy's.
};

/// What a cell states of a field.
struct StatedFacts {
  double error = 0;
  Range range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// The tetrahedra of a cut, by the hierarchy's numbers of vertices.
struct TetraCells {
  std::vector<tetra_mt::Tetrahedron> corners;
  std::vector<std::uint32_t> makers;   ///< By cell: its node, or kNone for the reference's.
  std::vector<std::uint32_t> regions;  ///< By cell: its place among those of the model.

  std::vector<StatedFacts> stated;  ///< Likewise, of one field, once that is filled in.

  explicit TetraCells(const tetra_mt::TetraCut& cut);
  explicit TetraCells(const tetra_mt::midpoint::MidpointCut& cut);
};

/// What the mesh of a cut is, as a mesh and in space.
struct TetraCutShape {
  std::uint64_t n_faces = 0;
  std::uint64_t n_crowded_faces = 0;  ///< Of more than two cells, or of two on the same side.
  std::uint64_t n_bad_made = 0;       ///< Cells that nodes made without positive volume,
  std::uint64_t n_bad_reference = 0;  ///< and those of the reference's.
  double volume = 0;                  ///< Of all, the negative too.
  double area = 0;                    ///< Of the outer faces, those of one cell.
  std::vector<std::array<std::uint32_t, 3>> outer;  ///< Counter-clockwise seen from outside.
};
[[nodiscard]] TetraCutShape shape_of(const TetraVertices& vertices, const TetraCells& cells);

/// The outer faces in floats: exactly, where positions are.
[[nodiscard]] Surface outer_surface(const TetraVertices& vertices, const TetraCutShape& shape);

}  // namespace lode
