#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/boundary_patch.h"
#include "lode/core/mesh_region.h"
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
  quadratic_hexahedron = 25,
  quadratic_wedge = 26,
  quadratic_pyramid = 27,
  triquadratic_hexahedron = 29,
  biquadratic_wedge = 32,
  polyhedron = 42,
  lagrange_tetrahedron = 71,
  lagrange_hexahedron = 72,
  lagrange_wedge = 73,
  lagrange_pyramid = 74,
};

/// An unstructured mesh as a file has it.
struct CellMesh {
  std::string path;  ///< What messages name: the file.
  std::vector<Vec3d> points;
  bool has_narrow_points = false;     ///< float32 holds all coordinates exactly.
  std::vector<std::uint8_t> types;    ///< By cell: a CellType, or a number that is none.
  std::vector<std::uint64_t> begins;  ///< By cell, and one more: its corners' place.
  std::vector<std::uint32_t> corners;
  /// By cell, and one more: where its faces begin, each as its number of corners and these. Only
  /// polyhedra have any; empty where the mesh has no polyhedra.
  std::vector<std::uint64_t> face_begins;
  std::vector<std::uint32_t> faces;
  std::vector<MeshField> point_fields;
  std::vector<MeshField> cell_fields;
  std::vector<BoundaryPatch> patch_names;   ///< Of cells with two dimensions, where a file has any.
  std::vector<MeshRegion> region_names;     ///< Likewise of those with three; of any bytes.
  std::optional<double> time{};             ///< Of the values, where the file says it.
  std::vector<double> times;                ///< Of the file's steps, ascending; empty: no series.
  std::size_t step = 0;                     ///< Of these the one whose values are here.
  std::vector<std::string> skipped_arrays;  ///< Those of no use: texts, bits, by corner.
  std::uint64_t n_ghost_cells = 0;          ///< Left out: copies of another piece's cells.
  std::uint64_t n_hidden_cells = 0;  ///< Left out: blanked ones, and those of blanked points.

  [[nodiscard]] std::size_t n_cells() const { return types.size(); }
  [[nodiscard]] std::span<const std::uint32_t> corners_of(std::size_t cell) const {
    return std::span(corners).subspan(static_cast<std::size_t>(begins[cell]),
                                      static_cast<std::size_t>(begins[cell + 1] - begins[cell]));
  }
  [[nodiscard]] std::span<const std::uint32_t> faces_of(std::size_t cell) const {
    if (face_begins.empty()) return {};
    return std::span(faces).subspan(
        static_cast<std::size_t>(face_begins[cell]),
        static_cast<std::size_t>(face_begins[cell + 1] - face_begins[cell]));
  }
};

}  // namespace lode
