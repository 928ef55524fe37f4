#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/built_model.h"
#include "lode/api/terrain_selection.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_file.h"

namespace lode {

/// Delaunay pyramids that are kept by levels: a mesh for each of their tolerances, and none between
/// or of tolerances that vary. Of a file levels are read when they are asked for, and what is wrong
/// with one is found then.
class PyramidTerrain final : public BuiltModel {
 public:
  explicit PyramidTerrain(delaunay_pyramid::Pyramid pyramid);
  explicit PyramidTerrain(delaunay_pyramid::PyramidFile file);

  /// Of all insertions, at tolerances that get finer, the last the finest of the history. Fails as
  /// encode() does.
  [[nodiscard]] static Result<std::shared_ptr<const PyramidTerrain>> build(
      const insertions::History& history, const TerrainBuildOptions& options,
      const std::vector<double>& levels, Progress& progress);
  [[nodiscard]] static Result<std::shared_ptr<const PyramidTerrain>> open(const std::string& path);

  [[nodiscard]] TerrainModel model() const override;
  [[nodiscard]] const terrain_file::Source& source() const override { return head_.source; }
  [[nodiscard]] double finest_error() const override { return head_.max_error; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override;
  /// Of a file with links, down these.
  [[nodiscard]] Result<std::shared_ptr<const TerrainParts>> parts(
      const TerrainOptions& options) const override;
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
  [[nodiscard]] std::uint64_t n_bytes_read() const override {
    return file_ ? file_->n_bytes_read() : 0;
  }

 private:
  using Shared = std::shared_ptr<const delaunay_pyramid::Pyramid>;

  /// With what the mesh of a level takes. Kept for the next question.
  [[nodiscard]] Result<Shared> with_mesh(std::size_t level, Progress& progress) const;
  [[nodiscard]] Result<Shared> all(Progress& progress) const;
  /// The first level within a tolerance, or the last.
  [[nodiscard]] std::size_t level_within(double tolerance) const;
  /// The level that the options mean, of a tolerance; sets what the report says of their being met.
  [[nodiscard]] std::size_t level_for(const TerrainOptions& options, double tolerance,
                                      TerrainReport& report) const;
  /// Fails on what asks for meshes of several levels at once.
  [[nodiscard]] Result<void> check_focus(const TerrainFocus& focus, double tolerance) const;
  /// verify_tin(tin, options) of each level.
  template <typename Verify>
  [[nodiscard]] Result<void> verify_levels(const delaunay_pyramid::Pyramid& pyramid,
                                           const Verify& verify_tin, Threads threads,
                                           VerifyReport& report) const;

  delaunay_pyramid::PyramidHead head_;
  std::shared_ptr<const delaunay_pyramid::PyramidFile> file_;  ///< Null: it was built.
  mutable std::mutex mutex_;
  mutable Shared loaded_;
  mutable std::optional<std::size_t> loaded_level_;  ///< Whose mesh it has; none: all levels.
};

}  // namespace lode
