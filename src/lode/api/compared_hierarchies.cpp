#include "lode/api/compared_hierarchies.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "lode/api/edge_walk.h"
#include "lode/api/lined_hierarchy.h"
#include "lode/api/point_hierarchy.h"
#include "lode/core/stopwatch.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"
#include "lode/models/terrain/triangle_hierarchy/locator.h"
#include "lode/models/terrain/triangle_hierarchy/variable.h"

namespace lode {
namespace {

class HierarchyCandidate : public TerrainCandidate {
 public:
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double> tolerances,
                                     Threads threads, Progress& progress) final {
    const Stopwatch watch;
    LODE_TRY(auto made, triangle_hierarchy::FineGrid::make(grid));
    surface_ = std::make_unique<const triangle_hierarchy::FineGrid>(std::move(made));
    LODE_CHECK(build(*surface_, falling(tolerances), threads, progress, nullptr));
    return finish(watch);
  }
  [[nodiscard]] Result<void> prepare_points(const PointTerrain& terrain,
                                            std::span<const double> tolerances, Threads threads,
                                            Progress& progress) final {
    const Stopwatch watch;
    const std::vector<double> levels = falling(tolerances);
    LODE_TRY(auto made, surface_of(terrain, progress));
    LODE_TRY(const auto first, first_mesh(terrain, *made, levels.front(), progress));
    surface_ = std::move(made);
    LODE_CHECK(build(*surface_, levels, threads, progress, &first));
    return finish(watch);
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress& progress) final {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const int level, hierarchy().level_within(tolerance));
    return Answer{.tin = tin_of_level(hierarchy(), level, delaunay::TinLinks::left_out),
                  .scale = hierarchy().scale(),
                  .stated_error = tolerance};
  }
  [[nodiscard]] std::optional<double> build_seconds() const final { return seconds_; }
  [[nodiscard]] ModelLevels levels() const final {
    return {hierarchy().n_levels(), "meshes that it is built in, one for each tolerance"};
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const final {
    return hierarchy().n_bytes() + chains_.n_bytes() + locator_->n_bytes();
  }
  [[nodiscard]] Result<std::optional<std::uint64_t>> zoom(double tolerance,
                                                          const TerrainWindow& window) final {
    LODE_TRY(const int level, hierarchy().level_within(tolerance));
    const auto found = find_in_window(hierarchy(), level, {window.lower, window.upper});
    return std::optional<std::uint64_t>(found.size());
  }
  [[nodiscard]] std::optional<std::uint64_t> locate(
      double tolerance, std::span<const delaunay::LatticePoint> places) final {
    const auto level = hierarchy().level_within(tolerance);
    if (!level) return {};
    return static_cast<std::uint64_t>(
        std::ranges::count_if(places, [&](const delaunay::LatticePoint& p) {
          const delaunay::Point at{{static_cast<double>(p.x), static_cast<double>(p.y)}};
          return locator_->find(*level, at).has_value();
        }));
  }
  [[nodiscard]] bool can_vary() const final { return true; }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) final {
    const triangle_hierarchy::MeasuredPatches errors(*surface_);
    const delaunay::Tin tin =
        tin_of_demand(hierarchy(), chains_, errors, middle_demand(hierarchy().frame, tolerance));
    return std::uint64_t{tin.triangles.size()};
  }
  [[nodiscard]] Neighbours neighbours() const final {
    return {Neighbours::Place::in_model,
            "the twins that triangles were made with, and what these are refined by"};
  }
  [[nodiscard]] std::uint64_t walk(double tolerance, std::uint64_t n_tries,
                                   std::uint64_t seed) final {
    const auto level = hierarchy().level_within(tolerance);
    if (!level) return 0;
    // The last one is of the level, whichever it is.
    std::uint32_t start = hierarchy().triangles_until[static_cast<std::size_t>(*level)] / 2;
    while (!hierarchy().is_in_level(start, *level)) ++start;
    return walk_edges(start, n_tries, seed, [&](std::uint32_t triangle, unsigned edge) {
      return hierarchy().neighbour(*level, triangle, edge);
    });
  }

 protected:
  virtual Result<void> build(const triangle_hierarchy::ReferenceSurface& surface,
                             std::span<const double> levels, Threads threads, Progress& progress,
                             const triangle_hierarchy::FirstMesh* first) = 0;
  [[nodiscard]] virtual const triangle_hierarchy::Hierarchy& hierarchy() const = 0;

 private:
  static std::vector<double> falling(std::span<const double> tolerances) {
    std::vector<double> levels(tolerances.begin(), tolerances.end());
    std::ranges::sort(levels, std::greater());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    return levels;
  }
  Result<void> finish(const Stopwatch& watch) {
    LODE_TRY(chains_, triangle_hierarchy::EdgeChains::find_in(hierarchy()));
    locator_.emplace(hierarchy());
    seconds_ = watch.seconds();
    return {};
  }

  std::unique_ptr<const triangle_hierarchy::ReferenceSurface> surface_;
  triangle_hierarchy::EdgeChains chains_;
  std::optional<triangle_hierarchy::Locator> locator_;
  double seconds_ = 0;
};

class Adaptive final : public HierarchyCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "adaptive_triangulation"; }
  [[nodiscard]] std::string what() const override {
    return "triangles split by five rules, on edges and inside, down to each tolerance: edges keep "
           "it between samples, too";
  }

 private:
  Result<void> build(const triangle_hierarchy::ReferenceSurface& surface,
                     std::span<const double> levels, Threads threads, Progress& progress,
                     const triangle_hierarchy::FirstMesh* first) override {
    LODE_TRY(made_, adaptive_triangulation::build(surface, levels, threads, progress, first));
    return {};
  }
  [[nodiscard]] const triangle_hierarchy::Hierarchy& hierarchy() const override {
    return made_.hierarchy;
  }

  adaptive_triangulation::AdaptiveTriangulation made_;
};

class Delaunay final : public HierarchyCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "hierarchical_delaunay"; }
  [[nodiscard]] std::string what() const override {
    return "triangles refined by Delaunay triangulations between chains of vertices on their "
           "edges";
  }

 private:
  Result<void> build(const triangle_hierarchy::ReferenceSurface& surface,
                     std::span<const double> levels, Threads threads, Progress& progress,
                     const triangle_hierarchy::FirstMesh* first) override {
    LODE_TRY(made_, hierarchical_delaunay::build(surface, levels, threads, progress, first));
    return {};
  }
  [[nodiscard]] const triangle_hierarchy::Hierarchy& hierarchy() const override {
    return made_.hierarchy;
  }

  hierarchical_delaunay::HierarchicalDelaunay made_;
};

}  // namespace

std::vector<std::unique_ptr<TerrainCandidate>> hierarchy_candidates() {
  std::vector<std::unique_ptr<TerrainCandidate>> all;
  all.push_back(std::make_unique<Adaptive>());
  all.push_back(std::make_unique<Delaunay>());
  return all;
}

}  // namespace lode
