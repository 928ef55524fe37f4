#include "lode/models/tetra_mt/region_match.h"

#include <algorithm>

namespace lode::tetra_mt {

std::vector<RegionCell> region_cells(const TetraMesh& mesh) {
  std::vector<RegionCell> cells;
  if (mesh.region_ids.empty()) return cells;
  cells.reserve(mesh.tetrahedra.size());
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    cells.emplace_back(mesh.tetrahedra[i],
                       mesh.region_ids[mesh.regions.empty() ? 0 : mesh.regions[i]]);
  return cells;
}

Result<void> check_same_regions(std::vector<RegionCell> ours, std::vector<RegionCell> theirs) {
  if (ours.empty() || theirs.empty()) return {};
  for (std::vector<RegionCell>* const cells : {&ours, &theirs}) {
    for (auto& [corners, region] : *cells) std::ranges::sort(corners);
    std::ranges::sort(*cells);
  }
  const auto [a, b] = std::ranges::mismatch(ours, theirs);
  if (a == ours.end() || b == theirs.end()) return {};
  const Tetrahedron& t = a->first;
  return fail(
      "expected the mesh that was built, with the cell of vertices {}, {}, {}, {} in region {}, "
      "got "
      "it in region {} (one that changes with time is none: --region-field names another)",
      t[0], t[1], t[2], t[3], a->second, b->second);
}

}  // namespace lode::tetra_mt
