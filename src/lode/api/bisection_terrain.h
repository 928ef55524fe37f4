#pragma once

#include <string>
#include <vector>

#include "lode/api/built_model.h"
#include "lode/api/terrain_selection.h"
#include "lode/models/terrain/bisection_file/bisection_file.h"

namespace lode {

/// Bisected right triangles: any tolerance, uniform or not, and any number of triangles, without
/// gaps.
class BisectionTerrain final : public BuiltModel {
 public:
  explicit BisectionTerrain(bisection_file::BisectionModel model) : model_(std::move(model)) {}

  [[nodiscard]] static Result<BisectionTerrain> build(const HeightGrid& grid,
                                                      const TerrainBuildOptions& options,
                                                      std::vector<double> levels,
                                                      Progress& progress);
  [[nodiscard]] static Result<BisectionTerrain> open(const std::string& path, Progress& progress);

  [[nodiscard]] const HeightGrid* samples() const override { return &model_.grid; }
  [[nodiscard]] TerrainModel model() const override {
    return TerrainModel::right_triangle_bisection;
  }
  [[nodiscard]] const terrain_file::Source& source() const override { return model_.source; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override;
  [[nodiscard]] Result<SelectedTerrain> select_all(Progress& progress) const override;
  [[nodiscard]] Result<std::uint64_t> save(const std::string& path,
                                           Progress& progress) const override;
  [[nodiscard]] BuiltTerrainInfo describe_source() const override;
  [[nodiscard]] Result<BuiltTerrainInfo> describe(Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify(const HeightGrid& grid, Threads threads,
                                            Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify_alone(Threads threads,
                                                  Progress& progress) const override;

 private:
  /// The mesh that the options mean without a focus; sets what the report says of their being met.
  [[nodiscard]] delaunay::Tin tin_for(const TerrainOptions& options, TerrainReport& report) const;

  bisection_file::BisectionModel model_;
};

}  // namespace lode
