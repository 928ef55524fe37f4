// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 7.1 and figure 14.
#include "lode/models/terrain/ternary_triangulation/ternary_triangulation.h"

#include <algorithm>

#include "lode/models/terrain/insertions/build.h"

namespace lode::ternary_triangulation {

using insertions::History;
using insertions::kNone;

Result<History> build(const HeightGrid& grid, double max_error, Progress& progress) {
  return insertions::build_history(grid, max_error, insertions::Model::ternary_triangulation,
                                   progress);
}

void add_parts(const History& history, std::uint32_t t, std::vector<std::uint32_t>& parts) {
  const auto& [corner, death, error] = history.triangles[t];
  if (death == kNone) return;
  for (std::uint32_t made = history.first_made[death]; made < history.first_made[death + 1];
       ++made) {
    // What was made stands on an edge of what was removed, as it turned there.
    const auto& base = history.triangles[made].corner;
    for (std::size_t i = 0; i < 3; ++i)
      if (corner[i] == base[0] && corner[(i + 1) % 3] == base[1]) parts.push_back(made);
  }
}

HierarchySize size_of(const History& history) {
  HierarchySize size{.n_regions = history.triangles.size()};
  std::vector<std::uint32_t> level(history.triangles.size(), 1);
  std::vector<std::uint32_t> parts;
  for (std::uint32_t t = 0; t < history.triangles.size(); ++t) {
    size.n_levels = std::max(size.n_levels, level[t]);
    if (history.triangles[t].death == kNone) ++size.n_expanded;
    parts.clear();
    add_parts(history, t, parts);
    for (const std::uint32_t part : parts) level[part] = level[t] + 1;
  }
  return size;
}

}  // namespace lode::ternary_triangulation
