#include "lode/io/cell_shapes.h"

namespace lode::io {

std::span<const Edge> edges_of(CellType type) {
  switch (type) {
    case CellType::tetrahedron:
    case CellType::quadratic_tetrahedron: return kTetrahedronEdges;
    case CellType::voxel: return kVoxelEdges;
    case CellType::hexahedron:
    case CellType::quadratic_hexahedron:
    case CellType::triquadratic_hexahedron: return kHexahedronEdges;
    case CellType::wedge:
    case CellType::quadratic_wedge:
    case CellType::biquadratic_wedge: return kWedgeEdges;
    case CellType::pyramid:
    case CellType::quadratic_pyramid:
    case CellType::lagrange_pyramid: return kPyramidEdges;
    default: return {};
  }
}

std::size_t n_corners_of(CellType type) {
  switch (type) {
    case CellType::tetrahedron:
    case CellType::quadratic_tetrahedron: return 4;
    case CellType::pyramid:
    case CellType::quadratic_pyramid:
    case CellType::lagrange_pyramid: return 5;
    case CellType::wedge:
    case CellType::quadratic_wedge:
    case CellType::biquadratic_wedge: return 6;
    default: return 8;
  }
}

}  // namespace lode::io
