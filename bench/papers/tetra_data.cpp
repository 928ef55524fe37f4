#include "bench/papers/tetra_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bench/timing.h"
#include "lode/core/progress.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/half_edge.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::bench {

using tetra_mt::PackedHierarchy;

Result<TetraData> prepare(const TetraCase& tetra_case) {
  LODE_TRY(TetraMesh mesh, load(tetra_case));
  const auto [low, high] = std::ranges::minmax(mesh.fields.front().values);
  Progress progress;
  const auto start = Clock::now();
  const auto base = static_cast<double>(mesh.tetrahedra.size()) * kTableBaseShare;
  LODE_TRY(const auto collapses,
           tetra_mt::collapse_half_edges(
               mesh, {.base_cells = static_cast<std::uint64_t>(base), .threads = kTableThreads},
               progress));
  LODE_TRY(const tetra_mt::Hierarchy hierarchy, make_hierarchy(mesh, collapses, kTableThreads));
  PackedHierarchy packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), kTableThreads);
  const double build_s = seconds_since(start);
  LODE_TRY(TetraDataset dataset,
           TetraDataset::build(mesh, {.base_share = kTableBaseShare, .threads = kTableThreads},
                               progress));
  SimplexMesh cells = oracles::to_simplex_mesh(mesh);
  const double margin = rounding_margin(cells.positions, {});
  return TetraData{tetra_case.name,   std::move(mesh),    std::move(cells), low,   high,
                   std::move(packed), std::move(dataset), build_s,          margin};
}

std::string milliseconds(double seconds) { return fmt::format("{:.1f}", seconds * 1e3); }

}  // namespace lode::bench
