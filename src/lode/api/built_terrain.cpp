#include "lode/api/built_terrain.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <utility>

#include "lode/api/bisection_terrain.h"
#include "lode/api/built_model.h"
#include "lode/api/hierarchy_terrain.h"
#include "lode/api/insertions_terrain.h"
#include "lode/api/opened_insertions.h"
#include "lode/api/pyramid_terrain.h"
#include "lode/api/quadtree_terrain.h"
#include "lode/core/out_of_memory.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/store/reader.h"

namespace lode {
namespace {

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

/// In units of the heights; of shares of no range 0 alone.
std::vector<double> levels_of(const TerrainBuildOptions& options, const HeightRange& range) {
  if (options.levels.empty()) return default_levels(range);
  if (!options.levels_are_shares) return options.levels;
  const double height = range.upper - range.lower;
  if (!(height > 0)) return {0};
  std::vector<double> levels;
  for (const double share : options.levels) levels.push_back(share * height);
  return levels;
}

/// The model of insertions that the options name.
Result<std::shared_ptr<const BuiltModel>> keep_insertions(insertions::History history,
                                                          const TerrainBuildOptions& options,
                                                          std::vector<double> levels,
                                                          Progress& progress) {
  history.sample_type = options.sample_type;
  history.has_place = options.has_place;
  if (is_pyramid_of_levels(options.model)) {
    LODE_TRY(auto made, PyramidTerrain::build(history, options, levels, progress));
    return std::shared_ptr<const BuiltModel>(std::move(made));
  }
  if (!history.is_worst_first()) levels.clear();
  return std::shared_ptr<const BuiltModel>(std::make_shared<const InsertionsTerrain>(
      insertions::LevelledHistory{std::move(history), std::move(levels)}));
}

/// Nothing where the file is of none, or cannot be read.
std::optional<TerrainModel> model_in(const std::string& path) {
  const auto name = store::Reader::model_of(path);
  return name ? built_model_of(*name) : std::nullopt;
}

}  // namespace

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

BuiltTerrain::BuiltTerrain(std::shared_ptr<const BuiltModel> model) : model_(std::move(model)) {}

Result<BuiltTerrain> BuiltTerrain::build(const HeightGrid& grid, const TerrainBuildOptions& options,
                                         Progress& progress) try {
  LODE_CHECK(check_levels(options.levels));
  LODE_EXPECTS(options.kept.empty() || is_on_squares(options.model));
  LODE_EXPECTS(!options.lined || is_hierarchy(options.model));
  const HeightRange range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(range));
  std::vector<double> levels = levels_of(options, range);
  if (is_quadtree(options.model)) {
    LODE_TRY(auto made, QuadtreeTerrain::build(grid, options, std::move(levels), progress));
    return BuiltTerrain(std::make_shared<const QuadtreeTerrain>(std::move(made)));
  }
  if (options.model == TerrainModel::right_triangle_bisection) {
    LODE_TRY(auto made, BisectionTerrain::build(grid, options, std::move(levels), progress));
    return BuiltTerrain(std::make_shared<const BisectionTerrain>(std::move(made)));
  }
  if (is_hierarchy(options.model)) {
    LODE_TRY(auto made, HierarchyTerrain::build(grid, options, levels, progress));
    return BuiltTerrain(std::make_shared<const HierarchyTerrain>(std::move(made)));
  }
  LODE_TRY(auto history, build_insertions(grid, options.model, levels.back(), progress));
  LODE_TRY(auto made, keep_insertions(std::move(history), options, std::move(levels), progress));
  return BuiltTerrain(std::move(made));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the model");
}

Result<BuiltTerrain> BuiltTerrain::build(const PointTerrain& terrain,
                                         const TerrainBuildOptions& options,
                                         Progress& progress) try {
  LODE_CHECK(check_levels(options.levels));
  LODE_EXPECTS(is_of_any_points(options.model) && options.kept.empty());
  const HeightRange range = height_range(terrain.points);
  std::vector<double> levels = levels_of(options, range);
  if (is_hierarchy(options.model)) {
    LODE_TRY(auto made, HierarchyTerrain::build(terrain, options, levels, progress));
    return BuiltTerrain(std::make_shared<const HierarchyTerrain>(std::move(made)));
  }
  LODE_TRY(auto history, build_insertions(terrain, options.model, levels.back(), progress));
  LODE_TRY(auto made, keep_insertions(std::move(history), options, std::move(levels), progress));
  return BuiltTerrain(std::move(made));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the model");
}

Result<BuiltTerrain> BuiltTerrain::open(const std::string& path, Progress& progress) try {
  const auto model = model_in(path);
  if (model && is_quadtree(*model)) {
    LODE_TRY(auto opened, QuadtreeTerrain::open(path, progress));
    return BuiltTerrain(std::make_shared<const QuadtreeTerrain>(std::move(opened)));
  }
  if (model == TerrainModel::right_triangle_bisection) {
    LODE_TRY(auto opened, BisectionTerrain::open(path, progress));
    return BuiltTerrain(std::make_shared<const BisectionTerrain>(std::move(opened)));
  }
  if (model && is_hierarchy(*model)) {
    LODE_TRY(auto opened, HierarchyTerrain::open(path));
    return BuiltTerrain(std::make_shared<const HierarchyTerrain>(std::move(opened)));
  }
  if (model && is_pyramid_of_levels(*model)) {
    LODE_TRY(auto opened, PyramidTerrain::open(path));
    return BuiltTerrain(std::move(opened));
  }
  LODE_TRY(auto opened, OpenedInsertions::open(path));
  return BuiltTerrain(std::move(opened));
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file", path);
}

bool BuiltTerrain::is_model_of(const std::string& path) { return model_in(path).has_value(); }

Result<std::uint64_t> BuiltTerrain::save(const std::string& path, Progress& progress) const try {
  return model_->save(path, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", path);
}

Terrain BuiltTerrain::terrain() const { return Terrain(model_); }
TerrainModel BuiltTerrain::model() const { return model_->model(); }
std::shared_ptr<const HeightGrid> BuiltTerrain::samples() const {
  const HeightGrid* samples = model_->samples();
  return samples == nullptr ? nullptr : std::shared_ptr<const HeightGrid>(model_, samples);
}
std::uint64_t BuiltTerrain::n_bytes_read() const { return model_->n_bytes_read(); }
const HeightFrame& BuiltTerrain::frame() const { return model_->source().frame; }
BuiltTerrainInfo BuiltTerrain::describe_source() const { return model_->describe_source(); }

Result<BuiltTerrainInfo> BuiltTerrain::describe(Progress& progress) const try {
  return model_->describe(progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("describe the model");
}

Result<VerifyReport> BuiltTerrain::verify(const HeightGrid& grid, Threads threads,
                                          Progress& progress) const try {
  return model_->verify(grid, threads, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("verify the model");
}

Result<VerifyReport> BuiltTerrain::verify(const PointTerrain& terrain, Threads threads,
                                          Progress& progress) const try {
  return model_->verify(terrain, threads, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("verify the model");
}

Result<VerifyReport> BuiltTerrain::verify_alone(Threads threads, Progress& progress) const try {
  return model_->verify_alone(threads, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("verify the model");
}

}  // namespace lode
