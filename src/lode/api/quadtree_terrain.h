#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lode/api/built_model.h"
#include "lode/api/terrain_selection.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"

namespace lode {

/// The models on squares. The surface quadtree and the quaternary triangulation have gaps: they
/// give triangles, whose tolerance may vary, heights, profiles and lines of sight on their leaves
/// (QuadtreePatches), and refuse what goes on from triangle to triangle, as contours do. The
/// restricted quadtree has none at one tolerance, and no other.
class QuadtreeTerrain final : public BuiltModel {
 public:
  explicit QuadtreeTerrain(quadtree_file::QuadtreeModel model) : model_(std::move(model)) {}

  [[nodiscard]] static Result<QuadtreeTerrain> build(const HeightGrid& grid,
                                                     const TerrainBuildOptions& options,
                                                     std::vector<double> levels,
                                                     Progress& progress);
  [[nodiscard]] static Result<QuadtreeTerrain> open(const std::string& path, Progress& progress);

  [[nodiscard]] const HeightGrid* samples() const override { return &model_.grid; }
  [[nodiscard]] TerrainModel model() const override;
  [[nodiscard]] const terrain_file::Source& source() const override { return model_.source; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override;
  [[nodiscard]] Result<SelectedTerrain> select_triangles(const TerrainOptions& options,
                                                         Progress& progress) const override;
  [[nodiscard]] Result<std::shared_ptr<const TerrainPatches>> patches(
      const TerrainOptions& options, Progress& progress) const override;
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
  [[nodiscard]] bool has_gaps() const { return lode::has_gaps(model()); }
  [[nodiscard]] const squares::SquareDomain& domain() const;
  /// Fails on what the model has no answer to.
  [[nodiscard]] Result<void> check_options(const TerrainOptions& options) const;
  /// The mesh, with heights and errors, and what the report says of it but for its error.
  [[nodiscard]] Result<SelectedTerrain> select_mesh(const TerrainOptions& options,
                                                    Progress& progress) const;
  [[nodiscard]] Result<delaunay::Tin> tin_within(double tolerance, Progress& progress) const;
  /// What the options ask for, or a number of triangles allows, which the report is told of.
  [[nodiscard]] double tolerance_for(const TerrainOptions& options, TerrainReport& report) const;
  /// Of those with gaps.
  [[nodiscard]] delaunay::Tin tin_of(const Demand& demand) const;
  /// Bilinear squares are no triangles: finds what these err by, where a TIN has errors of squares.
  void measure_errors(delaunay::Tin& tin) const;
  /// Holds triangles of bilinear squares against what a focus asks at each sample in them.
  [[nodiscard]] Result<void> judge_triangles(const TerrainFocus& focus,
                                             SelectedTerrain& selected) const;

  quadtree_file::QuadtreeModel model_;
};

}  // namespace lode
