#include "lode/api/terrain_selection.h"

#include <algorithm>
#include <utility>

#include "lode/core/stopwatch.h"

namespace lode {
namespace {

/// Of the range of heights, where nothing else is said; as of volumes.
constexpr double kDefaultShare = 0.005;

double tolerance_of(const HeightGrid& grid, const TerrainOptions& options) {
  if (options.max_error) return *options.max_error;
  if (options.max_cells) return 0;
  const HeightRange range = height_range(grid);
  return std::max(0.0, kDefaultShare * (range.upper - range.lower));
}

}  // namespace

Result<SelectedTerrain> select_terrain(const HeightGrid& grid, const TerrainOptions& options,
                                       delaunay::TinLinks links, Progress& progress) {
  const Stopwatch watch;
  const double max_error = tolerance_of(grid, options);
  const delaunay_selector::SelectorOptions wanted{
      .max_error = max_error,
      .max_cells = options.max_cells,
      .order = options.max_cells ? InsertionOrder::strict : options.order,
      .links = links};
  // What is asked of may have more triangles than a file should: all samples are had sooner than
  // those that matter.
  const bool is_full = max_error == 0 && !options.max_cells && links == delaunay::TinLinks::kept;
  LODE_TRY(delaunay_selector::Selection selection,
           is_full ? delaunay_selector::select_all_samples(grid)
                   : delaunay_selector::select_samples(grid, wanted, progress));
  const TerrainReport report{.triangles = selection.tin.triangles.size(),
                             .vertices = selection.tin.vertices.size(),
                             .max_error = max_error,
                             .achieved_error = selection.achieved_error,
                             .is_within_error = selection.is_within_error,
                             .budget_met = selection.is_within_cells,
                             .n_samples = selection.n_samples,
                             .n_missing = grid.n_missing(),
                             .n_left_out = selection.n_left_out,
                             .seconds = watch.seconds()};
  return SelectedTerrain{std::move(selection), report};
}

}  // namespace lode
