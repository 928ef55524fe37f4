#include "lode/render/mesh_volume.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

Result<void> check_vertices(const SimplexMesh& mesh) {
  constexpr double kLargestNumber = 1e150;  // Its square is still a double.
  if (mesh.values.size() != mesh.positions.size())
    return fail("mesh: expected {} values, one per vertex, got {}", mesh.positions.size(),
                mesh.values.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (const double coordinate : mesh.positions[v].v) {
      if (!(std::abs(coordinate) <= kLargestNumber))
        return fail("mesh: expected positions up to {}, vertex {} has {}", kLargestNumber, v,
                    coordinate);
    }
    if (!(std::abs(mesh.values[v]) <= kLargestNumber))
      return fail("mesh: expected values up to {}, vertex {} has {}", kLargestNumber, v,
                  mesh.values[v]);
  }
  return {};
}

}  // namespace

Box3d bounds_of_cells(const SimplexMesh& mesh) {
  if (mesh.tetrahedra.empty()) return {};
  const Vec3d& first = mesh.positions[mesh.tetrahedra.front()[0]];
  Box3d box{first, first};
  for (const auto& cell : mesh.tetrahedra) {
    for (const std::uint32_t v : cell) {
      for (std::size_t i = 0; i < 3; ++i) {
        box.lower[i] = std::min(box.lower[i], mesh.positions[v][i]);
        box.upper[i] = std::max(box.upper[i], mesh.positions[v][i]);
      }
    }
  }
  return box;
}

Result<MeshVolume> MeshVolume::build(const SimplexMesh& mesh, Threads threads) try {
  LODE_CHECK(check_vertices(mesh));
  LODE_TRY(CellLinks links, link_cells(mesh, threads));
  const Box3d bounds = bounds_of_cells(mesh);
  return MeshVolume(mesh, std::move(links), bounds);
} catch (const std::bad_alloc&) {
  return out_of_memory("prepare the mesh for rays");
}

}  // namespace lode
