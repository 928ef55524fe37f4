#pragma once

#include <gtest/gtest.h>

#include "lode/mappers/mesh_isosurface.h"
#include "lode/mappers/surface_topology.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::test {

/// A grid of n samples an axis over [0, 1]^3, with noise, in five tetrahedra a cell.
inline SimplexMesh noise(int n) {
  return oracles::to_simplex_mesh(oracles::noise_mesh(n, oracles::Cut::in_five, 1));
}

/// The same in six, with a field of one's own.
template <typename Value>
SimplexMesh grid_of(int n, const Value& value) {
  SimplexMesh mesh = oracles::to_simplex_mesh(oracles::noise_mesh(n, oracles::Cut::in_six, 1));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.values[v] = value(mesh.positions[v]);
  return mesh;
}

/// The corner of the unit cube at 0, with values 1, 2, 3 and 4.
inline SimplexMesh one_tetrahedron() {
  SimplexMesh mesh;
  mesh.positions = {Vec3d{{0, 0, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 1, 0}}, Vec3d{{0, 0, 1}}};
  mesh.values = {1, 2, 3, 4};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.errors = {0.25F};
  return mesh;
}

inline Surface isosurface_of(const SimplexMesh& mesh, double isovalue, Threads threads = {2},
                             const Vec3d& origin = {}) {
  Surface surface;
  surface.origin = origin;
  add_isosurface(mesh, isovalue,
                 {.margin = rounding_margin(mesh.positions, origin), .threads = threads}, surface);
  return surface;
}

inline void expect_manifold(const Surface& surface) {
  const TopologyReport report = check_topology(surface, {});
  EXPECT_TRUE(report.is_clean_manifold())
      << "edges " << report.non_manifold_edges.count << ", turned "
      << report.inconsistent_edges.count << ", vertices " << report.non_manifold_vertices.count
      << ", isolated " << report.isolated_vertices.count << ", degenerate "
      << report.degenerate_simplices.count << ", twice " << report.duplicate_vertices.count;
}

}  // namespace lode::test
