#include "lode/models/tetra_mt/mesh_check.h"

#include <algorithm>
#include <cmath>

#include "lode/core/label.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/interfaces.h"

namespace lode::tetra_mt {
namespace {

/// Volumes of what is so far from the origin are finite.
constexpr double kFarthest = 2e100;
/// Volumes in what is as large, or of no extent at all, do not vanish.
constexpr double kSmallestExtent = 1e-101;

Result<void> check_extent(const TetraMesh& mesh) {
  if (mesh.positions.empty()) return {};
  double extent = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](const Vec3d& p) { return p[i]; };
    const auto [low, high] = std::ranges::minmax(mesh.positions, {}, at);
    extent = std::max(extent, high[i] - low[i]);
  }
  if (extent == 0 || extent >= kSmallestExtent) return {};
  return fail("expected a mesh that is {} across or more, got one of {}", kSmallestExtent, extent);
}

Result<void> check_labels(const TetraMesh& mesh) {
  if (!mesh.region_names.empty() && mesh.region_names.size() != mesh.region_ids.size())
    return fail("expected no names of regions or {}, got {}", mesh.region_ids.size(),
                mesh.region_names.size());
  for (const std::string& name : mesh.region_names)
    if (const auto fault = label_fault(name))
      return fail("expected names of regions in one line of UTF-8, got {}", *fault);
  for (const BoundaryPatch& patch : mesh.patches)
    if (const auto fault = label_fault(patch.name))
      return fail("expected names of patches in one line of UTF-8, got {}", *fault);
  return {};
}

Result<void> check_patches(const TetraMesh& mesh) {
  if (mesh.patches.size() > kMaxPatches || mesh.region_ids.size() >= kOutsideLabel - kMaxPatches)
    return fail("expected up to {} patches and regions, got {} and {}", kMaxPatches,
                mesh.patches.size(), mesh.region_ids.size());
  for (std::size_t i = 0; i < mesh.patch_faces.size(); ++i)
    if (mesh.patch_faces[i].patch >= mesh.patches.size())
      return fail("face {}: expected a patch below {}, got {}", i, mesh.patches.size(),
                  mesh.patch_faces[i].patch);
  return {};
}

}  // namespace

Result<void> check_mesh(const TetraMesh& mesh) {
  const std::size_t n = mesh.positions.size();
  if (n >= kNone) return fail("expected fewer than {} vertices, got {}", kNone, n);
  for (std::size_t v = 0; v < n; ++v)
    if (!(length(mesh.positions[v]) <= kFarthest))
      return fail("vertex {}: expected a position up to {} from the origin, got {} {} {}", v,
                  kFarthest, mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
  LODE_CHECK(check_extent(mesh));
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (const std::uint32_t v : mesh.tetrahedra[i])
      if (v >= n) return fail("tetrahedron {}: expected corners below {}, got {}", i, n, v);
  if (!mesh.regions.empty() && mesh.regions.size() != mesh.tetrahedra.size())
    return fail("expected no regions or {}, got {}", mesh.tetrahedra.size(), mesh.regions.size());
  for (std::size_t i = 0; i < mesh.regions.size(); ++i)
    if (mesh.regions[i] >= mesh.region_ids.size())
      return fail("tetrahedron {}: expected a region below {}, got {}", i, mesh.region_ids.size(),
                  mesh.regions[i]);
  LODE_CHECK(check_labels(mesh));
  LODE_CHECK(check_patches(mesh));
  for (const MeshField& field : mesh.fields) {
    if (field.values.size() != n)
      return fail("field {}: expected {} values, got {}", field.name, n, field.values.size());
    for (std::size_t v = 0; v < n; ++v)
      if (!std::isfinite(field.values[v]))
        return fail("field {}: expected finite values, got {} at vertex {}", field.name,
                    field.values[v], v);
    if (n > 0) {
      const auto [low, high] = std::ranges::minmax(field.values);
      if (!std::isfinite(high - low))
        return fail("field {}: expected a range that doubles hold, got {} to {}", field.name, low,
                    high);
    }
  }
  return {};
}

}  // namespace lode::tetra_mt
