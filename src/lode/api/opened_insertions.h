#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "lode/api/built_model.h"
#include "lode/api/insertions_terrain.h"
#include "lode/models/terrain/insertions/history_file.h"

namespace lode {

/// A file of insertions, of which each question reads what it takes: with a focus, or at places,
/// the pages near it; of one tolerance all pages up to the time when it is kept; of all there is,
/// all.
class OpenedInsertions final : public BuiltModel {
 public:
  [[nodiscard]] static Result<std::shared_ptr<const OpenedInsertions>> open(
      const std::string& path);
  explicit OpenedInsertions(insertions::HistoryFile file)
      : file_(std::make_shared<const insertions::HistoryFile>(std::move(file))) {}

  [[nodiscard]] TerrainModel model() const override;
  [[nodiscard]] const terrain_file::Source& source() const override { return file_->base(); }
  [[nodiscard]] double finest_error() const override { return file_->base().max_error; }
  [[nodiscard]] Result<SelectedTerrain> select(const TerrainOptions& options,
                                               delaunay::TinLinks links,
                                               Progress& progress) const override;
  /// Of one tolerance, where the tolerance's mesh is that of a time.
  [[nodiscard]] Result<std::shared_ptr<const TerrainParts>> parts(
      const TerrainOptions& options) const override;
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
  [[nodiscard]] std::uint64_t n_bytes_read() const override { return file_->reads().n_bytes; }

 private:
  /// Of the fewest nodes that a demand wants: from the pages near them, or of a great part of all
  /// nodes from all.
  [[nodiscard]] Result<delaunay::Tin> tin_of_demand(const Demand& demand, Progress& progress) const;
  /// Where the mesh is that the options mean, if a tolerance says which; null else.
  [[nodiscard]] const insertions::ToleranceStep* step_for(const TerrainOptions& options,
                                                          double tolerance) const;
  [[nodiscard]] std::size_t n_bands_for(const TerrainOptions& options) const;
  /// By the history where that is at hand, or such a mesh is asked for again.
  /// Fails, naming the file, where it is not what the step says.
  [[nodiscard]] Result<delaunay::Tin> tin_of_step(const insertions::ToleranceStep& step,
                                                  Progress& progress) const;
  /// With the nodes of the first bands, or more. Kept for the next question.
  [[nodiscard]] Result<std::shared_ptr<const insertions::History>> history(
      std::size_t n_bands, Progress& progress) const;
  /// As if it had just been built. Kept, too.
  [[nodiscard]] Result<std::shared_ptr<const InsertionsTerrain>> whole(Progress& progress) const;
  /// Adds whether what the file says of levels and steps is so.
  [[nodiscard]] Result<void> check_said(Progress& progress, VerifyReport& report) const;

  std::shared_ptr<const insertions::HistoryFile> file_;
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const insertions::History> history_;
  mutable std::size_t n_bands_ = 0;    ///< Of the history.
  mutable bool has_answered_ = false;  ///< With a mesh of a time.
  mutable std::shared_ptr<const InsertionsTerrain> whole_;
};

}  // namespace lode
