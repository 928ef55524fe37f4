#pragma once

// The surface in a unit cell with the tetrahedra's topology, but with vertices on the cell's own
// edges alone: what marching cubes would make of it.

#include "lode/mappers/kuhn_cube.h"

namespace lode {

/// As kuhn_cube_cases(), without the vertices on face diagonals, and without the one on the body
/// diagonal but for the cases that cannot do without (needs_body_vertex()).
///
/// Vertices are those of the tetrahedra's surface. Each of its pieces, a disc or once an annulus,
/// is triangulated anew between its loops on the cell's faces. A crossed face diagonal joins
/// corners of different signs, so just two of the face's edges are crossed: without its vertex,
/// both cells join these two. No other edge of a triangle lies in a face, where it could be another
/// cell's too.
[[nodiscard]] const KuhnCubeCases& cube_cases(int parity, bool is_mirrored);

/// Whether a cell keeps the vertex on its body diagonal, by its inside corners as coordinates
/// modulo 2 (bit k: the corner that is odd along the axes of k): 14 of 256. There the loop has 9 or
/// 12 vertices, and no triangulation without chords in faces.
[[nodiscard]] bool needs_body_vertex(unsigned corners);

}  // namespace lode
