#pragma once

// How the tetrahedra's surface in a unit cell goes onto the cube's triangles: what bounds how far
// the two are from each other by a few vertices.

#include <array>
#include <cstdint>

namespace lode {

/// Let the vertices on diagonals of the cell's faces go onto the segments between the faces'
/// crossed edges, the one on the body diagonal, if it is crossed, to a point of the cube's
/// triangles, and let the tetrahedra's triangles follow. Where this says how, that is continuous,
/// takes the tetrahedra's patches onto all of the cube's, and is linear on parts of their polygons,
/// so no point goes farther than the farthest vertex.
///
/// An edge between two of the cube's triangles that has both ends in one tetrahedron lies on the
/// tetrahedra's surface, too. Cut along these, each part with nothing inside has all its vertices
/// on the border of one of the cube's triangles, and so goes onto it. With the body diagonal the
/// tetrahedra's surface is a fan round its vertex, of which such edges cut off ears: what is left
/// is one triangle, or two with the edge between them, where that vertex may go.
struct CubeFollowing {
  enum class Body : std::uint8_t {
    unknown,      ///< Nothing is said.
    none,         ///< The body diagonal is not crossed.
    on_edge,      ///< Its vertex may go anywhere on the edge between the first two vertices,
    in_triangle,  ///< or in the triangle.
  };
  Body body = Body::unknown;
  std::array<std::uint8_t, 3> vertices{};  ///< Of cube_cases(0, false).
};

/// By the inside corners of a cell whose lowest corner is even.
[[nodiscard]] const CubeFollowing& cube_following(unsigned corners);

}  // namespace lode
