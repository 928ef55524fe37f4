#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/attribute.h"
#include "lode/core/boundary_patch.h"
#include "lode/core/mesh_region.h"
#include "lode/core/vec.h"

namespace lode {

/// The corners of a tetrahedron's face across from one of them: counter-clockwise seen from outside
/// where the tetrahedron is of positive volume.
[[nodiscard]] inline std::array<std::uint32_t, 3> face_across(
    const std::array<std::uint32_t, 4>& cell, std::size_t corner) {
  constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces{
      {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  const auto& [a, b, c] = kFaces[corner];
  return {cell[a], cell[b], cell[c]};
}

/// A face on a mesh's boundary, and the patch that it is of.
struct PatchSide {
  std::uint32_t cell;
  std::uint32_t corner;  ///< Across from the face.
  std::uint32_t patch;   ///< Its place among the patches.
};

/// A conforming mesh of tetrahedra or triangles (exactly one of the two is used) with a field that
/// is linear on each. Positions are world coordinates in doubles, unlike those of a Surface: a mesh
/// has five or six cells of 20 bytes for each vertex, so that floats would save a tenth of it only,
/// and without rounding and origin its volume is the domain's and cells can be cut further.
struct SimplexMesh {
  std::vector<Vec3d> positions;
  std::vector<double> values;                            ///< Per vertex.
  bool has_narrow_values = false;                        ///< float32 holds all values exactly.
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;  ///< Of positive volume.
  std::vector<std::array<std::uint32_t, 3>> triangles;   ///< Counter-clockwise, z up.
  std::vector<std::int64_t> regions;     ///< Per cell, as the file numbers them; empty: one.
  std::vector<MeshRegion> region_names;  ///< Of those that have one, by id, ascending.
  std::vector<BoundaryPatch> patches;    ///< Of tetrahedra; empty: none.
  std::vector<PatchSide> patch_sides;    ///< By cell and corner.
  std::vector<Attribute> attributes;     ///< Further fields.
  std::vector<float> errors;             ///< Per cell: proven bound of |F - F'| on it, field units.

  [[nodiscard]] std::size_t n_cells() const { return tetrahedra.size() + triangles.size(); }
  [[nodiscard]] bool is_empty() const { return n_cells() == 0; }
  [[nodiscard]] std::array<std::uint32_t, 3> corners_of(const PatchSide& side) const {
    return face_across(tetrahedra[side.cell], side.corner);
  }
};

}  // namespace lode
