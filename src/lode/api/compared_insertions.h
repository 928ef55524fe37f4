#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/compared_terrain.h"
#include "lode/api/terrain_model.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/window.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode {

/// The insertions into a grid that a model is, and what they keep the tolerances with.
struct SharedHistory {
  TerrainModel model;
  std::optional<insertions::History> history;
  std::vector<double> levels;  ///< That get finer.
  std::vector<insertions::NodeSet> nodes;
  double seconds = 0;

  explicit SharedHistory(TerrainModel its_model) : model(its_model) {}
  /// Once.
  Result<void> build(const HeightGrid& grid, std::span<const double> tolerances,
                     Progress& progress);
  Result<void> build(const PointTerrain& terrain, std::span<const double> tolerances,
                     Progress& progress);
  [[nodiscard]] std::size_t level_of(double tolerance) const {
    return static_cast<std::size_t>(std::ranges::find(levels, tolerance) - levels.begin());
  }
};

/// Of one history, by levels.
class HistoryCandidate : public TerrainCandidate {
 public:
  explicit HistoryCandidate(std::shared_ptr<SharedHistory> shared) : shared_(std::move(shared)) {}

  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double> tolerances,
                                     Threads /*threads*/, Progress& progress) final {
    LODE_CHECK(shared_->build(grid, tolerances, progress));
    return time_encoding(progress);
  }
  [[nodiscard]] Result<void> prepare_points(const PointTerrain& terrain,
                                            std::span<const double> tolerances, Threads /*threads*/,
                                            Progress& progress) final {
    LODE_CHECK(shared_->build(terrain, tolerances, progress));
    return time_encoding(progress);
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress& progress) final {
    if (progress.is_cancelled()) return cancelled_error();
    return Answer{.tin = tin_of_level(shared_->level_of(tolerance)), .stated_error = tolerance};
  }
  [[nodiscard]] std::optional<double> build_seconds() const final {
    return shared_->seconds + encoding_seconds_;
  }
  /// Of an encoding by levels.
  [[nodiscard]] ModelLevels levels() const override {
    return {static_cast<int>(shared_->levels.size()),
            "meshes that it is built in, one for each tolerance"};
  }
  [[nodiscard]] Result<std::optional<std::uint64_t>> zoom(double tolerance,
                                                          const TerrainWindow& window) final {
    return zoom_level(shared_->level_of(tolerance), delaunay::Window{window.lower, window.upper});
  }
  [[nodiscard]] std::optional<std::uint64_t> locate(
      double tolerance, std::span<const delaunay::LatticePoint> places) final {
    return locate_in_level(shared_->level_of(tolerance), places);
  }

 protected:
  virtual Result<void> encode(Progress& progress) = 0;
  [[nodiscard]] virtual delaunay::Tin tin_of_level(std::size_t level) = 0;
  [[nodiscard]] virtual std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                                const delaunay::Window& window) = 0;
  [[nodiscard]] virtual std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) = 0;
  /// How many of the places find(place) finds.
  template <typename Find>
  static std::uint64_t count_found(std::span<const delaunay::LatticePoint> places,
                                   const Find& find) {
    return static_cast<std::uint64_t>(std::ranges::count_if(
        places, [&](const delaunay::LatticePoint& p) { return find(p).has_value(); }));
  }
  [[nodiscard]] const insertions::History& history() const { return *shared_->history; }
  [[nodiscard]] const SharedHistory& shared() const { return *shared_; }

 private:
  Result<void> time_encoding(Progress& progress) {
    const Stopwatch watch;
    LODE_CHECK(encode(progress));
    encoding_seconds_ = watch.seconds();
    return {};
  }

  std::shared_ptr<SharedHistory> shared_;
  double encoding_seconds_ = 0;
};

/// The history itself.
[[nodiscard]] std::unique_ptr<TerrainCandidate> insertions_candidate(
    std::shared_ptr<SharedHistory> shared);

}  // namespace lode
