#include "lode/api/built_terrain.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "lode/api/built_terrain_impl.h"
#include "lode/api/terrain_focus.h"
#include "lode/api/terrain_selection.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/implicit_pyramid/build.h"
#include "lode/models/terrain/insertions/build.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode {
namespace {

using insertions::History;

/// The largest error of a TIN's triangles.
double largest_error(const delaunay::Tin& tin) {
  return tin.errors.empty() ? 0.0 : static_cast<double>(*std::ranges::max_element(tin.errors));
}

class BuiltOrigin final : public TerrainOrigin {
 public:
  explicit BuiltOrigin(std::shared_ptr<const BuiltTerrain::Impl> built)
      : built_(std::move(built)) {}

  [[nodiscard]] const HeightFrame& frame() const override { return history().frame; }
  [[nodiscard]] HeightRange range() const override { return history().range; }
  [[nodiscard]] double finest_error() const override { return history().max_error; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options, delaunay::TinLinks,
                                               Progress& progress) const override {
    const Stopwatch watch;
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const double tolerance, tolerance_of(options));
    SelectedTerrain selected;
    TerrainReport& report = selected.report;
    if (options.focus) {
      const auto& outside = options.focus->max_error_outside;
      if (outside && *outside < history().max_error)
        return fail(
            "expected a tolerance of {} or more outside the focus, which is what the "
            "model was built for, got {}",
            history().max_error, *outside);
      if (options.max_cells) return fail("expected a focus or a number of triangles, got both");
      LODE_TRY(const Demand demand, to_demand(*options.focus, tolerance));
      selected.tin = tin_of(history(), select_nodes(history(), demand), delaunay::TinLinks::kept);
      report.is_uniform = false;
      report.is_focus_empty =
          selected.tin.triangles.size() == history().n_base_triangles() && history().n_nodes() > 0;
    } else {
      selected.tin = tin_for(options, tolerance, report);
    }
    report.triangles = selected.tin.triangles.size();
    report.vertices = selected.tin.vertices.size();
    report.max_error = tolerance;
    report.achieved_error = largest_error(selected.tin);
    // Errors of triangles are rounded up; that of all samples is known better.
    if (report.triangles == finest_triangles())
      report.achieved_error = std::min(report.achieved_error, history().max_error);
    report.n_samples = history().n_samples;
    report.n_missing = history().n_missing;
    report.n_left_out = history().n_left_out;
    report.seconds = watch.seconds();
    return selected;
  }

 private:
  [[nodiscard]] const History& history() const { return built_->levelled.history; }
  [[nodiscard]] std::uint64_t finest_triangles() const {
    return history().triangles.size() - history().removed.size();
  }
  [[nodiscard]] Result<double> tolerance_of(const TerrainOptions& options) const {
    const double tolerance = default_tolerance(options, history().range);
    const double finest = history().max_error;
    if (options.max_error && tolerance < finest)
      return fail(
          "expected a tolerance of {} or more, which is what the model was built for, "
          "got {}",
          finest, tolerance);
    return options.max_cells && !options.max_error ? 0.0 : std::max(tolerance, finest);
  }
  [[nodiscard]] delaunay::Tin tin_for(const TerrainOptions& options, double tolerance,
                                      TerrainReport& report) const {
    constexpr auto kLinks = delaunay::TinLinks::kept;
    report.is_within_error = history().max_error <= tolerance;
    delaunay::Tin within;
    if (!options.max_cells || options.max_error)
      within = tin_of(history(), nodes_within(history(), tolerance), kLinks);
    if (!options.max_cells || (options.max_error && within.triangles.size() <= *options.max_cells))
      return within;
    const auto nodes = nodes_of_cells(history(), *options.max_cells);
    report.budget_met = nodes.has_value();
    delaunay::Tin tin = tin_of(history(), nodes.value_or(insertions::NodeSet(0)), kLinks);
    report.is_within_error = largest_error(tin) <= tolerance;
    return tin;
  }

  std::shared_ptr<const BuiltTerrain::Impl> built_;
};

Result<void> check_levels(const std::vector<double>& levels) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!(levels[i] >= 0 && std::isfinite(levels[i])))
      return fail("levels: expected finite tolerances >= 0, got {}", levels[i]);
    if (i > 0 && levels[i] >= levels[i - 1])
      return fail("levels: expected tolerances that get finer, got {} after {}", levels[i],
                  levels[i - 1]);
  }
  if (levels.size() > terrain_file::kMaxLevels)
    return fail("levels: expected up to {}, got {}", terrain_file::kMaxLevels, levels.size());
  return {};
}

}  // namespace

Result<History> build_insertions(const HeightGrid& grid, TerrainModel model, double max_error,
                                 Progress& progress) {
  LODE_EXPECTS(model != TerrainModel::delaunay_selector);
  if (model == TerrainModel::implicit_delaunay_pyramid)
    return implicit_pyramid::build(grid, progress);
  return insertions::build_history(grid, max_error,
                                   model == TerrainModel::ternary_triangulation
                                       ? insertions::Model::ternary_triangulation
                                       : insertions::Model::delaunay_pyramid,
                                   progress);
}

std::vector<double> default_levels(const HeightRange& range) {
  constexpr double kFinestShare = 0.0005;
  constexpr int kMostDefaultLevels = 11;  // 2^11 of the finest are more than the range.
  const double height = range.upper - range.lower;
  const double finest = kFinestShare * height;
  if (!(finest > 0)) return {0};
  std::vector<double> levels;
  for (int k = kMostDefaultLevels - 1; k >= 0; --k) {
    const double level = std::ldexp(finest, k);
    if (level < height || k == 0) levels.push_back(level);
  }
  return levels;
}

BuiltTerrain::BuiltTerrain(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

Result<BuiltTerrain> BuiltTerrain::build(const HeightGrid& grid, const TerrainBuildOptions& options,
                                         Progress& progress) try {
  LODE_CHECK(check_levels(options.levels));
  const HeightRange range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(range));
  std::vector<double> levels = options.levels.empty() ? default_levels(range) : options.levels;
  LODE_TRY(History history, build_insertions(grid, options.model, levels.back(), progress));
  history.sample_type = options.sample_type;
  history.has_place = options.has_place;
  if (!history.is_worst_first()) levels.clear();
  return BuiltTerrain(
      std::make_shared<const Impl>(Impl{insertions::LevelledHistory{std::move(history), levels}}));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the model");
}

Result<BuiltTerrain> BuiltTerrain::open(const std::string& path, Progress& progress) try {
  LODE_TRY(insertions::LevelledHistory levelled, insertions::open(path, progress));
  return BuiltTerrain(std::make_shared<const Impl>(Impl{std::move(levelled)}));
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file", path);
}

bool BuiltTerrain::is_model_of(const std::string& path) { return insertions::is_model_of(path); }

Result<std::uint64_t> BuiltTerrain::save(const std::string& path, Progress& progress) const try {
  return insertions::save(impl_->levelled, path, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", path);
}

Terrain BuiltTerrain::terrain() const {
  return Terrain(std::make_shared<const BuiltOrigin>(impl_));
}

TerrainModel BuiltTerrain::model() const {
  switch (impl_->levelled.history.model) {
    case insertions::Model::ternary_triangulation: return TerrainModel::ternary_triangulation;
    case insertions::Model::implicit_delaunay_pyramid:
      return TerrainModel::implicit_delaunay_pyramid;
    default: return TerrainModel::delaunay_pyramid;
  }
}

const HeightFrame& BuiltTerrain::frame() const { return impl_->levelled.history.frame; }

BuiltTerrainInfo BuiltTerrain::describe_source() const {
  const History& history = impl_->levelled.history;
  BuiltTerrainInfo info;
  info.sample_type = history.sample_type;
  info.has_place = history.has_place;
  info.n_nodes = history.n_nodes();
  info.n_base_triangles = history.n_base_triangles();
  info.n_triangles = history.triangles.size();
  info.memory_bytes = history.n_bytes();
  info.n_samples = history.n_samples;
  info.n_missing = history.n_missing;
  info.n_left_out = history.n_left_out;
  info.range = history.range;
  info.max_error = history.max_error;
  return info;
}

BuiltTerrainInfo BuiltTerrain::describe() const {
  const History& history = impl_->levelled.history;
  BuiltTerrainInfo info = describe_source();
  const auto add = [&](double tolerance, std::uint32_t time) {
    const delaunay::Tin tin = tin_at(history, time, delaunay::TinLinks::kept);
    const TinAngles angles = measure_angles(tin, history.frame, {});
    if (!history.is_worst_first()) tolerance = largest_error(tin);
    info.levels.push_back(
        {tolerance, tin.triangles.size(), tin.vertices.size(), angles.smallest, angles.median});
  };
  for (const double tolerance : impl_->levelled.levels)
    add(tolerance, time_within(history, tolerance));
  for (const std::uint32_t end : history.level_ends) add(0, end);
  return info;
}

}  // namespace lode
