#include "lode/api/compared_insertions.h"

#include <functional>

#include "lode/api/insertions_terrain.h"
#include "lode/api/point_terrain.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/history_locator.h"
#include "lode/models/terrain/ternary_triangulation/ternary_triangulation.h"
#include "lode/refine/focus.h"

namespace lode {
namespace {

/// The history itself.
class Insertions final : public HistoryCandidate {
 public:
  using HistoryCandidate::HistoryCandidate;
  [[nodiscard]] std::string name() const override { return name_of(shared().model); }
  [[nodiscard]] std::string what() const override {
    switch (shared().model) {
      case TerrainModel::ternary_triangulation:
        return "triangles joined to their worst samples, never flipped, worst first: any "
               "tolerance, which may vary";
      case TerrainModel::implicit_delaunay_pyramid:
        return "all samples, in levels that lose a fraction of them whatever their errors: any "
               "tolerance, which may vary";
      default:
        return "all insertions of the strict selector, with every triangle that there ever was "
               "(hypertriangulation): any tolerance, which may vary";
    }
  }
  [[nodiscard]] bool can_vary() const override { return true; }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    const FocusDemand demand = middle_demand(history().frame, tolerance);
    return tin_of(history(), select_nodes(history(), demand), delaunay::TinLinks::left_out)
        .triangles.size();
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return history().n_bytes() + locator_->n_bytes();
  }
  [[nodiscard]] Neighbours neighbours() const override { return sorted_twins(); }
  [[nodiscard]] ModelLevels levels() const override {
    switch (shared().model) {
      case TerrainModel::ternary_triangulation:
        return {static_cast<int>(ternary_triangulation::size_of(history()).n_levels),
                "triangles nested in each other, at most"};
      case TerrainModel::implicit_delaunay_pyramid:
        return {static_cast<int>(history().level_ends.size()),
                "its own, above the outline: insertions that do not depend on each other"};
      default:
        return {static_cast<int>(shared().levels.size()),
                "tolerances that it was built for; it has all between, too"};
    }
  }

 private:
  Result<void> encode(Progress&) override {
    locator_.emplace(history());
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    // Levels of worst-first histories are known as times; other sets are part of the answer.
    const insertions::NodeSet& known = shared().nodes[level];
    if (history().is_worst_first()) return tin_of(history(), known, delaunay::TinLinks::left_out);
    return tin_of(history(), nodes_within(history(), shared().levels[level]),
                  delaunay::TinLinks::left_out);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const delaunay::Window& window) override {
    return zoom_in(history(), shared().nodes[level], window).size();
  }
  [[nodiscard]] std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) override {
    return count_found(places, [&](delaunay::LatticePoint p) {
      const delaunay::Point at{{static_cast<double>(p.x), static_cast<double>(p.y)}};
      return locator_->find(shared().nodes[level], at);
    });
  }

  std::optional<insertions::HistoryLocator> locator_;
};

}  // namespace

namespace {

template <typename Ground>
Result<void> build_history(const Ground& ground, std::span<const double> tolerances,
                           Progress& progress, SharedHistory& shared) {
  if (shared.history) return {};
  shared.levels.assign(tolerances.begin(), tolerances.end());
  std::ranges::sort(shared.levels, std::greater());
  shared.levels.erase(std::unique(shared.levels.begin(), shared.levels.end()), shared.levels.end());
  const Stopwatch watch;
  LODE_TRY(shared.history, build_insertions(ground, shared.model, shared.levels.back(), progress));
  shared.seconds = watch.seconds();
  for (const double level : shared.levels)
    shared.nodes.push_back(nodes_within(*shared.history, level));
  return {};
}

}  // namespace

Result<void> SharedHistory::build(const HeightGrid& grid, std::span<const double> tolerances,
                                  Progress& progress) {
  return build_history(grid, tolerances, progress, *this);
}

Result<void> SharedHistory::build(const PointTerrain& terrain, std::span<const double> tolerances,
                                  Progress& progress) {
  return build_history(terrain, tolerances, progress, *this);
}

std::unique_ptr<TerrainCandidate> insertions_candidate(std::shared_ptr<SharedHistory> shared) {
  return std::make_unique<Insertions>(std::move(shared));
}

}  // namespace lode
