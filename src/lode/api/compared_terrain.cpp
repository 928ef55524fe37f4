#include "lode/api/compared_terrain.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "lode/api/compared_bisection.h"
#include "lode/api/compared_hierarchies.h"
#include "lode/api/compared_pyramid.h"
#include "lode/api/compared_quadtrees.h"
#include "lode/api/edge_walk.h"
#include "lode/api/point_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/tin_quality.h"
#include "lode/models/terrain/delaunay_selector/selector.h"

namespace lode {
namespace {

ModelLevels no_levels() { return {0, "none: each tolerance has one mesh, made anew"}; }

class Selector final : public TerrainCandidate {
 public:
  explicit Selector(InsertionOrder order) : order_(order) {}

  [[nodiscard]] std::string name() const override {
    return order_ == InsertionOrder::strict ? "delaunay_selector, strict" : "delaunay_selector";
  }
  [[nodiscard]] std::string what() const override {
    return order_ == InsertionOrder::strict ? "greedy insertion, always of the worst of all samples"
                                            : "greedy insertion of samples, errors falling by "
                                              "octaves; made anew for each tolerance";
  }
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>, Threads,
                                     Progress&) override {
    grid_ = &grid;
    return {};
  }
  [[nodiscard]] Result<void> prepare_points(const PointTerrain& terrain, std::span<const double>,
                                            Threads, Progress&) override {
    points_ = &terrain;
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress& progress) override {
    // Not select_terrain(), which takes all samples for a tolerance of 0.
    const delaunay_selector::SelectorOptions options{
        .max_error = tolerance, .order = order_, .links = delaunay::TinLinks::kept};
    LODE_TRY(delaunay_selector::Selection selected,
             points_ != nullptr ? delaunay_selector::select_points(points_->points, points_->domain,
                                                                   options, progress)
                                : delaunay_selector::select_samples(*grid_, options, progress));
    return Answer{.tin = std::move(selected.tin), .stated_error = selected.achieved_error};
  }
  [[nodiscard]] bool is_made_anew() const override { return true; }
  [[nodiscard]] ModelLevels levels() const override { return no_levels(); }
  [[nodiscard]] Neighbours neighbours() const override {
    return {Neighbours::Place::in_mesh, "the twins that its mesh is made with"};
  }

 private:
  InsertionOrder order_;
  const HeightGrid* grid_ = nullptr;
  const PointTerrain* points_ = nullptr;  ///< In its place.
};

/// Every s-th column and row, and the last ones.
std::vector<std::int32_t> every(std::int32_t step, std::int32_t n) {
  std::vector<std::int32_t> places;
  for (std::int32_t i = 0; i < n - 1; i += step) places.push_back(i);
  places.push_back(n - 1);
  return places;
}

class Subsampling final : public TerrainCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "regular grid"; }
  [[nodiscard]] std::string what() const override {
    return "the baseline: every s-th column and row, s the largest of 256, 192, 128, 96, ... 2, 1 "
           "within "
           "the tolerance";
  }
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>,
                                     Threads threads, Progress&) override {
    if (grid.n_missing() > 0)
      return fail("a grid of which every s-th sample stays has no place for {} missing samples",
                  grid.n_missing());
    grid_ = &grid;
    threads_ = threads;
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress& progress) override {
    Answer answer;
    for (const std::int32_t step : {256, 192, 128, 96, 64, 48, 32, 24, 16, 12, 8, 6, 4, 3, 2, 1}) {
      if (progress.is_cancelled()) return cancelled_error();
      answer.tin = tin_of(step);
      answer.stated_error = error_of(step);
      step_ = step;
      if (*answer.stated_error <= tolerance) break;
    }
    return answer;
  }
  [[nodiscard]] bool is_made_anew() const override { return true; }
  [[nodiscard]] ModelLevels levels() const override { return no_levels(); }
  [[nodiscard]] Neighbours neighbours() const override {
    return {Neighbours::Place::in_model, "by its columns and rows"};
  }
  [[nodiscard]] std::uint64_t walk(double /*tolerance*/, std::uint64_t n_tries,
                                   std::uint64_t seed) override {
    const auto n_columns = static_cast<std::uint32_t>(every(step_, grid_->n_columns).size() - 1);
    const auto n_rows = static_cast<std::uint32_t>(every(step_, grid_->n_rows).size() - 1);
    const std::uint32_t middle = 2 * (n_rows / 2 * n_columns + n_columns / 2);
    return walk_edges(middle, n_tries, seed, [&](std::uint32_t triangle, unsigned edge) {
      return behind_in_grid(n_columns, n_rows, triangle, edge);
    });
  }

 private:
  [[nodiscard]] delaunay::Tin tin_of(std::int32_t step) const {
    const auto columns = every(step, grid_->n_columns);
    const auto rows = every(step, grid_->n_rows);
    delaunay::Tin tin;
    for (const std::int32_t y : rows)
      for (const std::int32_t x : columns) {
        tin.vertices.push_back({x, y});
        tin.heights.push_back(grid_->height(x, y));
      }
    const auto width = static_cast<std::uint32_t>(columns.size());
    for (std::uint32_t y = 0; y + 1 < rows.size(); ++y)
      for (std::uint32_t x = 0; x + 1 < width; ++x) {
        const std::uint32_t a = y * width + x;
        tin.triangles.push_back({a, a + 1, a + width + 1});
        tin.triangles.push_back({a, a + width + 1, a + width});
      }
    return tin;
  }
  /// Looked for once a step, as for any other model.
  double error_of(std::int32_t step) {
    const auto known = std::ranges::find(errors_, step, &std::pair<std::int32_t, double>::first);
    if (known != errors_.end()) return known->second;
    errors_.emplace_back(step, measure_quality(tin_of(step), 1, *grid_, threads_).worst_error);
    return errors_.back().second;
  }

  const HeightGrid* grid_ = nullptr;
  Threads threads_;
  std::int32_t step_ = 1;  ///< Of the last mesh.
  std::vector<std::pair<std::int32_t, double>> errors_;
};

}  // namespace

Result<void> TerrainCandidate::prepare_points(const PointTerrain& /*terrain*/,
                                              std::span<const double> /*tolerances*/,
                                              Threads /*threads*/, Progress& /*progress*/) {
  return fail(
      "its vertices are taken by columns and rows, in which scattered points are not; a raster is "
      "needed");
}

Result<std::uint64_t> TerrainCandidate::extract_middle(double /*tolerance*/,
                                                       Progress& /*progress*/) {
  return fail("{}: expected a model whose tolerance may vary", name());
}

Result<std::optional<std::uint64_t>> TerrainCandidate::zoom(double /*tolerance*/,
                                                            const TerrainWindow& /*window*/) {
  return std::optional<std::uint64_t>();
}

std::optional<std::uint64_t> TerrainCandidate::locate(
    double /*tolerance*/, std::span<const delaunay::LatticePoint> /*places*/) {
  return {};
}

std::string TerrainCandidate::why_not(ModelPart part) const {
  switch (part) {
    case ModelPart::memory: return "nothing is kept but the raster or the points";
    case ModelPart::file: return "nothing is kept that could be written";
    case ModelPart::links: return "it has none";
    case ModelPart::variable: return "a mesh is made for one tolerance";
    case ModelPart::zoom:
    case ModelPart::location: return "nothing is kept but its mesh, in which heights are found";
  }
  return {};
}

Result<std::shared_ptr<const TerrainPatches>> TerrainCandidate::patches(double /*tolerance*/,
                                                                        Progress& /*progress*/) {
  return std::shared_ptr<const TerrainPatches>();
}

std::uint64_t TerrainCandidate::walk(double /*tolerance*/, std::uint64_t /*n_tries*/,
                                     std::uint64_t /*seed*/) {
  return 0;
}

Neighbours sorted_twins() {
  return {Neighbours::Place::in_mesh, "the twins of its mesh, found by sorting its edges"};
}

FocusDemand middle_demand(const HeightFrame& frame, double tolerance) {
  Vec<double, 2> lower = frame.world(0.375 * (frame.n_columns - 1), 0.375 * (frame.n_rows - 1));
  Vec<double, 2> upper = frame.world(0.625 * (frame.n_columns - 1), 0.625 * (frame.n_rows - 1));
  for (std::size_t i = 0; i < 2; ++i)
    if (lower[i] > upper[i]) std::swap(lower[i], upper[i]);
  constexpr double kAll = std::numeric_limits<double>::max();
  FocusDemand demand;
  demand.foci = {BoxFocus{{{{lower[0], lower[1], -kAll}}, {{upper[0], upper[1], kAll}}}}};
  demand.inside = tolerance;
  demand.outside = 10 * tolerance;
  return demand;
}

std::vector<std::unique_ptr<TerrainCandidate>> terrain_candidates(std::uint64_t memory_limit) {
  std::vector<std::unique_ptr<TerrainCandidate>> all;
  all.push_back(std::make_unique<Selector>(InsertionOrder::levels));
  all.push_back(std::make_unique<Selector>(InsertionOrder::strict));
  for (auto& candidate : pyramid_candidates(memory_limit)) all.push_back(std::move(candidate));
  for (auto& candidate : hierarchy_candidates()) all.push_back(std::move(candidate));
  for (auto& candidate : quadtree_candidates()) all.push_back(std::move(candidate));
  all.push_back(bisection_candidate());
  all.push_back(std::make_unique<Subsampling>());
  return all;
}

}  // namespace lode
