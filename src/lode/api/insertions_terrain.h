#pragma once

#include <mutex>

#include "lode/api/built_model.h"
#include "lode/api/point_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/models/terrain/insertions/persist.h"

namespace lode {

/// Models that are insertions: two Delaunay pyramids and the ternary triangulation.
class InsertionsTerrain final : public BuiltModel {
 public:
  explicit InsertionsTerrain(insertions::LevelledHistory levelled)
      : levelled_(std::move(levelled)) {}

  [[nodiscard]] TerrainModel model() const override;
  [[nodiscard]] const terrain_file::Source& source() const override { return history(); }
  [[nodiscard]] double finest_error() const override { return history().max_error; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override;
  /// Of an implicit pyramid, which has all samples as vertices.
  [[nodiscard]] Result<SelectedTerrain> select_all(Progress& progress) const override;
  [[nodiscard]] Result<std::uint64_t> save(const std::string& path,
                                           Progress& progress) const override;
  [[nodiscard]] BuiltTerrainInfo describe_source() const override;
  [[nodiscard]] Result<BuiltTerrainInfo> describe(Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify(const HeightGrid& grid, Threads threads,
                                            Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify(const PointTerrain& terrain, Threads threads,
                                            Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify_alone(Threads threads,
                                                  Progress& progress) const override;

  [[nodiscard]] const insertions::History& history() const { return levelled_.history; }
  /// Of each level.
  [[nodiscard]] Result<std::vector<insertions::LevelFacts>> facts(Progress& progress) const {
    LODE_CHECK(find_facts(progress));
    return levelled_.facts;
  }

 private:
  /// verify_tin(tin, options) of each level.
  template <typename Verify>
  [[nodiscard]] Result<void> verify_levels(const Verify& verify_tin, Threads threads,
                                           VerifyReport& report) const;
  /// Found once.
  [[nodiscard]] Result<void> find_facts(Progress& progress) const;

  mutable std::mutex mutex_;  ///< Of the levels' facts.
  mutable insertions::LevelledHistory levelled_;
};

/// Of one of these models; an implicit pyramid has all samples, whatever max_error.
[[nodiscard]] Result<insertions::History> build_insertions(const HeightGrid& grid,
                                                           TerrainModel model, double max_error,
                                                           Progress& progress);
/// Of one that is_of_any_points(), and no is_hierarchy().
[[nodiscard]] Result<insertions::History> build_insertions(const PointTerrain& terrain,
                                                           TerrainModel model, double max_error,
                                                           Progress& progress);

}  // namespace lode
