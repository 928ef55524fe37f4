#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/attribute.h"
#include "lode/core/boundary_patch.h"
#include "lode/core/mesh_region.h"
#include "lode/core/vec.h"

namespace lode {

/// Bytes that a vector has room for.
template <typename T>
[[nodiscard]] std::uint64_t capacity_bytes(const std::vector<T>& vector) {
  return std::uint64_t{vector.capacity()} * sizeof(T);
}

/// Where full resolution has vertices: on all edges of the tetrahedra, so that the surface is the
/// exact level set of F, or on those of the grid's cells alone, a third of the triangles.
enum class SurfaceStyle : std::uint8_t { tetra, cubes };

/// An extracted isosurface or section (triangles), or a set of contour lines (lines): exactly one
/// of the two is used. World position of vertex i = origin + positions[i]; the origin is zero
/// unless the coordinates are too large for float32 (see docs/models/diamond3d.md).
struct Surface {
  Vec3d origin{{0, 0, 0}};
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;         ///< Unit length, per vertex; may be empty.
  std::vector<double> isovalues;      ///< Per vertex, where there are several.
  std::vector<double> values;         ///< The field, per vertex; may be empty.
  std::vector<Attribute> attributes;  ///< Further fields.
  /// Per vertex where it is moved from by a refinement step, as positions; NaN where it has no such
  /// place; may be empty.
  std::vector<Vec3f> origins;
  std::vector<float> errors;  ///< Of the field, per cell; may be empty.
  std::vector<std::int64_t>
      regions;  ///< Of a mesh, as its file numbers them, per cell; may be empty.
  std::vector<MeshRegion> region_names;    ///< Of those that have one, by id, ascending.
  std::vector<BoundaryPatch> patches;      ///< Parts of a mesh's boundary.
  std::vector<std::uint32_t> patch_marks;  ///< By triangle: 0, or one more than its patch's place.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Counter-clockwise from lower values.
  std::vector<std::array<std::uint32_t, 2>> lines;      ///< Lower values on the right, z up.

  [[nodiscard]] bool is_empty() const { return triangles.empty() && lines.empty(); }
  /// Memory that the vectors have.
  [[nodiscard]] std::uint64_t n_bytes() const;
  /// Gives back what vertices, normals, isovalues and triangles do not need.
  void shrink_to_fit();
  [[nodiscard]] Vec3d world_position(std::uint32_t vertex) const;
  /// Empties the vectors but keeps their memory, so that a Surface can be filled again.
  void clear();
};

}  // namespace lode
