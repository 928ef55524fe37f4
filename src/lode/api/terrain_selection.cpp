#include "lode/api/terrain_selection.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "lode/api/point_terrain.h"
#include "lode/core/stopwatch.h"
#include "lode/models/terrain/delaunay_selector/selector.h"

namespace lode {
namespace {

/// Of the range of heights, where nothing else is said; as of volumes.
constexpr double kDefaultShare = 0.005;

class Raster final : public TerrainOrigin {
 public:
  explicit Raster(std::shared_ptr<const HeightGrid> grid) : grid_(std::move(grid)) {}
  [[nodiscard]] const HeightFrame& frame() const override { return *grid_; }
  [[nodiscard]] HeightRange range() const override { return height_range(*grid_); }
  [[nodiscard]] bool is_raster() const override { return true; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override {
    return select_terrain(*grid_, options, links, progress);
  }

 private:
  std::shared_ptr<const HeightGrid> grid_;
};

/// Calls select(its options) or select_all(), and says what came of it.
template <typename Select, typename SelectAll>
Result<SelectedTerrain> selected(const TerrainOptions& options, const HeightRange& range,
                                 delaunay::TinLinks links, const Select& select,
                                 const SelectAll& select_all) {
  const Stopwatch watch;
  if (options.focus)
    return fail(
        "expected one tolerance for all of a terrain, got a focus: the delaunay_selector makes one "
        "TIN, the model delaunay_pyramid can vary");
  const double max_error = default_tolerance(options, range);
  const delaunay_selector::SelectorOptions wanted{
      .max_error = max_error,
      .max_cells = options.max_cells,
      .order = options.max_cells ? InsertionOrder::strict : options.order,
      .links = links,
      .threads = options.threads};
  // What is asked of may have more triangles than a file should: all samples are had sooner than
  // those that matter.
  const bool is_full = max_error == 0 && !options.max_cells && links == delaunay::TinLinks::kept;
  LODE_TRY(delaunay_selector::Selection selection, is_full ? select_all() : select(wanted));
  const TerrainReport report{.triangles = selection.tin.triangles.size(),
                             .vertices = selection.tin.vertices.size(),
                             .max_error = max_error,
                             .achieved_error = selection.achieved_error,
                             .is_within_error = selection.is_within_error,
                             .budget_met = selection.is_within_cells,
                             .n_samples = selection.n_samples,
                             .n_left_out = selection.n_left_out,
                             .seconds = watch.seconds()};
  return SelectedTerrain{std::move(selection.tin), report};
}

}  // namespace

Result<std::optional<delaunay::Tin>> TerrainParts::within(const delaunay::Point& /*lower*/,
                                                          const delaunay::Point& /*upper*/,
                                                          Progress& /*progress*/) const {
  return std::optional<delaunay::Tin>();
}

Result<std::optional<delaunay::Tin>> TerrainParts::crossing(std::span<const double> /*heights*/,
                                                            Progress& /*progress*/) const {
  return std::optional<delaunay::Tin>();
}

Result<std::optional<HeightRange>> TerrainParts::height_range(Progress& /*progress*/) const {
  return std::optional<HeightRange>();
}

Result<SelectedTerrain> TerrainOrigin::select_triangles(const TerrainOptions& options,
                                                        Progress& progress) const {
  return select(options, delaunay::TinLinks::kept, progress);
}

Result<std::shared_ptr<const TerrainParts>> TerrainOrigin::parts(
    const TerrainOptions& /*options*/) const {
  return std::shared_ptr<const TerrainParts>{};
}

Result<std::shared_ptr<const TerrainPatches>> TerrainOrigin::patches(
    const TerrainOptions& /*options*/, Progress& /*progress*/) const {
  return std::shared_ptr<const TerrainPatches>{};
}

Result<SelectedTerrain> TerrainOrigin::select_all(Progress& progress) const {
  return select({.max_error = 0}, delaunay::TinLinks::kept, progress);
}

// Of another's grid.
Terrain::Terrain(const HeightGrid& grid)
    : Terrain(std::shared_ptr<const HeightGrid>(std::shared_ptr<void>(), &grid)) {}

Terrain::Terrain(std::shared_ptr<const HeightGrid> grid)
    : origin_(std::make_shared<const Raster>(std::move(grid))) {}

double default_tolerance(const TerrainOptions& options, const HeightRange& range) {
  if (options.max_error) return *options.max_error;
  if (options.max_cells) return 0;
  return std::max(0.0, kDefaultShare * (range.upper - range.lower));
}

Result<SelectedTerrain> select_terrain(const HeightGrid& grid, const TerrainOptions& options,
                                       delaunay::TinLinks links, Progress& progress) {
  const bool is_given = options.max_error || options.max_cells;
  LODE_TRY(SelectedTerrain made, selected(
                                     options, is_given ? HeightRange{} : height_range(grid), links,
                                     [&](const delaunay_selector::SelectorOptions& wanted) {
                                       return delaunay_selector::select_samples(grid, wanted,
                                                                                progress);
                                     },
                                     [&] { return delaunay_selector::select_all_samples(grid); }));
  made.report.n_missing = grid.n_missing();
  return made;
}

Result<SelectedTerrain> select_terrain(const PointTerrain& terrain, const TerrainOptions& options,
                                       delaunay::TinLinks links, Progress& progress) {
  return selected(
      options, height_range(terrain.points), links,
      [&](const delaunay_selector::SelectorOptions& wanted) {
        return delaunay_selector::select_points(terrain.points, terrain.domain, wanted, progress);
      },
      [&] {
        return delaunay_selector::select_all_points(terrain.points, terrain.domain, progress);
      });
}

}  // namespace lode
