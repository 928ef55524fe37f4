#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/built_model.h"
#include "lode/api/loaded_levels.h"
#include "lode/api/terrain_selection.h"
#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode {

/// The models of triangles refined into triangulations. They have a mesh for each of their
/// tolerances, and meshes of tolerances that vary. Vertices are nodes of a lattice finer than that
/// of the raster or the points. Of a file levels are read when they are asked for, and what is
/// wrong with one is found then.
class HierarchyTerrain final : public BuiltModel {
 public:
  using Surface = std::unique_ptr<const triangle_hierarchy::ReferenceSurface>;

  /// With its raster or points what is between levels is measured, and else bounded.
  explicit HierarchyTerrain(hierarchy_file::HierarchyModel model, Surface surface = {});
  explicit HierarchyTerrain(hierarchy_file::HierarchyFile file);

  [[nodiscard]] static Result<HierarchyTerrain> build(const HeightGrid& grid,
                                                      const TerrainBuildOptions& options,
                                                      const std::vector<double>& levels,
                                                      Progress& progress);
  /// Of scattered points, or of a raster with breaklines.
  [[nodiscard]] static Result<HierarchyTerrain> build(const PointTerrain& terrain,
                                                      const TerrainBuildOptions& options,
                                                      const std::vector<double>& levels,
                                                      Progress& progress);
  [[nodiscard]] static Result<HierarchyTerrain> open(const std::string& path);

  [[nodiscard]] TerrainModel model() const override;
  [[nodiscard]] const terrain_file::Source& source() const override { return head_.source; }
  [[nodiscard]] const HeightFrame& frame() const override { return fine_frame_; }
  [[nodiscard]] double finest_error() const override { return head_.tolerances.back(); }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override;
  [[nodiscard]] Result<std::uint64_t> save(const std::string& path,
                                           Progress& progress) const override;
  [[nodiscard]] BuiltTerrainInfo describe_source() const override;
  [[nodiscard]] Result<BuiltTerrainInfo> describe(Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify(const HeightGrid& grid, Threads threads,
                                            Progress& progress) const override;
  /// Of points; of a raster with features alone: whether the lines are those.
  [[nodiscard]] Result<VerifyReport> verify(const PointTerrain& terrain, Threads threads,
                                            Progress& progress) const override;
  [[nodiscard]] Result<VerifyReport> verify_alone(Threads threads,
                                                  Progress& progress) const override;

 private:
  [[nodiscard]] Result<LoadedLevels::Shared> all_levels(Progress& progress) const {
    return levels_->first(head_.n_levels(), progress);
  }
  [[nodiscard]] double tolerance(int level) const {
    return head_.tolerances[static_cast<std::size_t>(level)];
  }
  /// The first level within a tolerance.
  [[nodiscard]] int level_within(double tolerance) const;
  /// The mesh that the options mean; sets what the report says of their being met.
  [[nodiscard]] Result<int> level_for(const TerrainOptions& options, TerrainReport& report) const;
  /// No sample errs by more in the mesh of a level.
  [[nodiscard]] double error_of_level(const triangle_hierarchy::Hierarchy& hierarchy,
                                      int level) const;

  [[nodiscard]] Result<SelectedTerrain> select_focused(const TerrainOptions& options,
                                                       Progress& progress) const;
  /// How many levels are enough for a focus.
  [[nodiscard]] int n_levels_for(const TerrainFocus& focus, double tolerance) const;

  hierarchy_file::Head head_;
  std::unique_ptr<LoadedLevels> levels_;
  Surface surface_;  ///< Files do not keep it.
  HeightFrame fine_frame_;
};

}  // namespace lode
