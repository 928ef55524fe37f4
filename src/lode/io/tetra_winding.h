#pragma once

#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/io/split_cells.h"
#include "lode/io/tetra_faces.h"
#include "lode/io/tetrahedra.h"

namespace lode::io {

/// Six times the volume of a tetrahedron, negative where it is wound the other way.
[[nodiscard]] inline double six_volumes(const std::vector<Vec3d>& points, const Tetrahedron& t) {
  const Vec3d& a = points[t[0]];
  return dot(cross(points[t[1]] - a, points[t[2]] - a), points[t[3]] - a);
}

/// Turns tetrahedra round and counts those of no and of negative volume, exactly. First all wedges'
/// where most of them are of the other sign than most other cells': some programs wind them so that
/// the first triangle faces the second one, some the other way. Then, in each component, those that
/// are not wound as most are, so that all see a face they share from different sides: as most are
/// that is of positive volume. What is of negative volume then is folded over its neighbours, and
/// stays. So does a polyhedron, whose tetrahedra are wound alike and of positive volume to begin
/// with: they turn together where it is folded, which is counted as inverted and not as turned.
/// Components that cannot be wound alike turn all cells but polyhedra, or none.
void turn_round(const CellMesh& mesh, const std::vector<Vec3d>& points, const TetraFaces& faces,
                SplitCells& split, TetraReport& report);

}  // namespace lode::io
