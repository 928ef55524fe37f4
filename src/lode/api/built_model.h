#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_focus.h"
#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_source.h"
#include "lode/models/terrain/terrain_file/source.h"

namespace lode {

/// One of kBuiltTerrainModels, as BuiltTerrain has it; what its members say holds here.
class BuiltModel : public TerrainOrigin {
 public:
  [[nodiscard]] virtual TerrainModel model() const = 0;
  [[nodiscard]] virtual const terrain_file::Source& source() const = 0;
  /// All heights of its raster, where it keeps them, else null.
  [[nodiscard]] virtual const HeightGrid* samples() const { return nullptr; }
  [[nodiscard]] virtual Result<std::uint64_t> save(const std::string& path,
                                                   Progress& progress) const = 0;
  [[nodiscard]] virtual BuiltTerrainInfo describe_source() const = 0;
  [[nodiscard]] virtual Result<BuiltTerrainInfo> describe(Progress& progress) const = 0;
  [[nodiscard]] virtual Result<VerifyReport> verify(const HeightGrid& grid, Threads threads,
                                                    Progress& progress) const = 0;
  /// Of models of points; others fail.
  [[nodiscard]] virtual Result<VerifyReport> verify(const PointTerrain& terrain, Threads threads,
                                                    Progress& progress) const;
  [[nodiscard]] virtual Result<VerifyReport> verify_alone(Threads threads,
                                                          Progress& progress) const = 0;

  /// Of its file, since it was opened; 0 where it has none, or has read all of it.
  [[nodiscard]] virtual std::uint64_t n_bytes_read() const { return 0; }

  /// Of models that keep all heights; others fail.
  [[nodiscard]] Result<SelectedTerrain> select_all(Progress& progress) const override;
  [[nodiscard]] const HeightFrame& frame() const override { return source().frame; }
  [[nodiscard]] HeightRange range() const final { return source().range; }
};

/// What a report says of the mesh's size and of the raster.
void count_selection(const terrain_file::Source& source, SelectedTerrain& selected);

/// What the report says of a mesh within a focus. The TIN has heights and errors; `frame`: of its
/// nodes.
void report_focus(const TerrainDemand& focus, const HeightFrame& frame, SelectedTerrain& selected);

/// Reports whether what a file says of its raster is so. Fails on rasters of another size.
[[nodiscard]] Result<void> check_source(const terrain_file::Source& source, const HeightGrid& grid,
                                        VerifyReport& report);

/// The same of points. Fails where it is of none, and on points of another lattice.
[[nodiscard]] Result<void> check_source(const terrain_file::Source& source,
                                        const PointTerrain& terrain, VerifyReport& report);

/// Reports whether a model's own samples are those of the raster.
void check_stored_heights(const HeightGrid& own, const HeightGrid& grid, VerifyReport& report);

/// How many nodes are no vertices.
[[nodiscard]] std::uint64_t count_lost(const std::vector<LatticePoint>& nodes,
                                       const delaunay::Tin& tin);

/// How far float64 may be off a plane through heights of the grid.
[[nodiscard]] double plane_rounding(const HeightGrid& grid);
/// How many triangles of a TIN state less than the error of a sample in them, by more than
/// rounding. `scale`: its nodes are so many to a cell. Fails when cancelled.
[[nodiscard]] Result<std::uint64_t> count_understated(const delaunay::Tin& tin, std::int32_t scale,
                                                      const HeightGrid& grid, double rounding,
                                                      Threads threads, Progress& progress);
/// Reports whether the errors that triangles of a TIN state are no less than those of all samples
/// in them. `scale`: its nodes are so many to a cell. Fails when cancelled.
[[nodiscard]] Result<void> check_stated_errors(const delaunay::Tin& tin, std::int32_t scale,
                                               const HeightGrid& grid, const char* name,
                                               Threads threads, Progress& progress,
                                               VerifyReport& report);

/// What is to be remembered of a raster. Fails as find_domain() and check_heights() do.
[[nodiscard]] Result<terrain_file::Source> source_of(const HeightGrid& grid,
                                                     const TerrainBuildOptions& options);

/// The largest error of a TIN's triangles, where it has errors, else 0.
[[nodiscard]] double largest_error(const delaunay::Tin& tin);

}  // namespace lode
