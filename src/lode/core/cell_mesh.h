#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/scalar_type.h"
#include "lode/core/vec.h"

namespace lode {

/// Values on the points or cells of a mesh, components side by side.
struct MeshField {
  std::string name;
  ScalarType type = ScalarType::float64;  ///< As the file has them.
  int n_components = 1;
  std::vector<double> values;

  [[nodiscard]] double at(std::size_t i, int component = 0) const {
    return values[i * static_cast<std::size_t>(n_components) + static_cast<std::size_t>(component)];
  }
};

/// Kinds of cells, numbered as VTK does.
enum class CellType : std::uint8_t {
  vertex = 1,
  line = 3,
  triangle = 5,
  quad = 9,
  tetrahedron = 10,
  voxel = 11,
  hexahedron = 12,
  wedge = 13,
  pyramid = 14,
  quadratic_tetrahedron = 24,
  polyhedron = 42,
};

/// An unstructured mesh as a file has it.
struct CellMesh {
  std::vector<Vec3d> points;
  bool has_narrow_points = false;     ///< float32 holds all coordinates exactly.
  std::vector<std::uint8_t> types;    ///< By cell: a CellType, or a number that is none.
  std::vector<std::uint64_t> begins;  ///< By cell, and one more: its corners' place.
  std::vector<std::uint32_t> corners;
  /// Of polyhedra, by cell: where its faces begin, each as its number of corners and these; empty
  /// where there are none.
  std::vector<std::uint64_t> face_begins;
  std::vector<std::uint32_t> faces;
  std::vector<MeshField> point_fields;
  std::vector<MeshField> cell_fields;

  [[nodiscard]] std::size_t n_cells() const { return types.size(); }
};

}  // namespace lode
