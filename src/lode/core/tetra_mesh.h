#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/boundary_patch.h"
#include "lode/core/cell_mesh.h"

namespace lode {

/// A mesh of tetrahedra with fields that are linear on each: what a multiresolution model of
/// unstructured data is built from.
struct TetraMesh {
  std::vector<Vec3d> positions;
  bool has_narrow_positions = false;  ///< float32 holds all coordinates exactly.
  /// Corners a, b, c, d: of positive volume where (b - a) x (c - a) . (d - a) > 0.
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;
  std::vector<std::uint32_t> regions;    ///< By tetrahedron: places in region_ids; empty: one.
  std::vector<std::int64_t> region_ids;  ///< As the file numbers them, ascending.
  /// By place in region_ids, empty of those without one; or none at all. Labels (label.h).
  std::vector<std::string> region_names;
  std::vector<BoundaryPatch> patches;  ///< By id, ascending.
  std::vector<PatchFace> patch_faces;  ///< Each once; what is on the boundary and none is free.
  std::vector<MeshField> fields;       ///< Of the vertices, one component each.
};

}  // namespace lode
