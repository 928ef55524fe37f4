#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/io/cell_shapes.h"

namespace lode::io {

/// A face's corners and the middles of its edges, each behind the corner it follows; its own middle
/// where the cell has one.
struct QuadraticFace {
  Face corners{};
  std::array<std::uint8_t, 4> middles{};
  std::optional<std::uint8_t> centre{};
};

/// A quadratic cell that is split round a point within, by places of its nodes.
struct QuadraticShape {
  std::span<const QuadraticFace> faces;
  std::optional<std::uint8_t> centre;  ///< The node in the middle, of hexahedra of 27.
  /// Else what each node counts for at the middle of the cell's parameters: the shape functions of
  /// finite elements there, which sum to 1, and of which some are negative.
  std::span<const double> weights;
};

/// Of hexahedra of 20 or 27 nodes, wedges of 15 or 18, pyramids of 13 or 14 (Bedrosian, Shape
/// functions and integration formulas for three-dimensional finite element analysis, 1992); nothing
/// of other cells, as of quadratic tetrahedra, which are split without a point more.
[[nodiscard]] std::optional<QuadraticShape> quadratic_shape(const CellMesh& mesh, std::size_t cell);

/// Whether a cell is one of these or a quadratic tetrahedron.
[[nodiscard]] bool is_quadratic(const CellMesh& mesh, std::size_t cell);

/// Triangles between the nodes of a quadratic cell's faces, wound as seen from outside of cells of
/// positive volume: one at each corner, and between the middles of edges one more, or two along the
/// diagonal that is nearer to the face's own middle; with a node there eight round it. So cells
/// that share a face's nodes agree. Of quadrilaterals with a side of no length, which has one point
/// for all of its nodes, those of the triangle that is left.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> quadratic_triangles(
    const CellMesh& mesh, const QuadraticShape& shape, std::span<const std::uint32_t> nodes);

/// Where a quadratic cell without a node in its middle is split round: the middle of its
/// parameters, or where that does not see all triangles, the innermost point (find_centre).
[[nodiscard]] std::optional<Vec3d> quadratic_centre(
    const CellMesh& mesh, std::size_t cell,
    std::span<const std::array<std::uint32_t, 3>> triangles);

/// Of a field of one component at points: what the cell's shape functions have at the middle of its
/// parameters, within the range of its nodes, so that no peak is higher than the file's; at another
/// centre what value_at_centre() has there.
[[nodiscard]] double value_at_quadratic_centre(const CellMesh& mesh, std::size_t cell,
                                               const Vec3d& centre,
                                               const std::vector<double>& values);

}  // namespace lode::io
