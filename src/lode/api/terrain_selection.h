#pragma once

#include "lode/api/terrain.h"
#include "lode/delaunay/tin.h"

namespace lode {

struct HeightPoints;
struct PointTerrain;

/// A TIN with heights, and what is to be said of it but for slacks of coordinates.
struct SelectedTerrain {
  delaunay::Tin tin;
  TerrainReport report;
};

/// The max_error of the options, or half a percent of the range, or with max_cells 0.
[[nodiscard]] double default_tolerance(const TerrainOptions& options, const HeightRange& range);

/// As TerrainOrigin::select(), of a raster and of scattered points; with links at tolerance 0: of
/// all samples. Fail as select_samples() and select_points() do.
[[nodiscard]] Result<SelectedTerrain> select_terrain(const HeightGrid& grid,
                                                     const TerrainOptions& options,
                                                     delaunay::TinLinks links, Progress& progress);
[[nodiscard]] Result<SelectedTerrain> select_terrain(const PointTerrain& terrain,
                                                     const TerrainOptions& options,
                                                     delaunay::TinLinks links, Progress& progress);

/// Of the TIN that TerrainOrigin::select() makes what meets a box, from a part of the model where
/// that has parts. Fails as that does, and where nothing meets the box.
[[nodiscard]] Result<SelectedTerrain> select_clipped(const Terrain& terrain,
                                                     const TerrainOptions& options,
                                                     const PlaceBox& box, TerrainClip& clip,
                                                     Progress& progress);

/// As verify_terrain(), of a TIN of points, with heights, before it is rounded to floats.
[[nodiscard]] Result<VerifyReport> verify_point_tin(const PointTerrain& terrain,
                                                    const delaunay::Tin& tin,
                                                    const TerrainVerifyOptions& options,
                                                    Progress& progress);

/// The same of a TIN of a grid's samples; not of tiles.
[[nodiscard]] Result<VerifyReport> verify_sample_tin(const HeightGrid& grid,
                                                     const delaunay::Tin& tin,
                                                     const TerrainVerifyOptions& options,
                                                     Progress& progress);

/// As verify_terrain(), of a TIN between the grid's samples: see check_fine_tin(). Errors up to
/// 2^-48 of the largest |height| are rounding.
[[nodiscard]] Result<VerifyReport> verify_fine_tin(const HeightGrid& grid, const delaunay::Tin& tin,
                                                   std::int32_t scale, double max_error,
                                                   Threads threads, Progress& progress);

/// The same of a TIN on a finer lattice than a terrain's points, which are `fine` there: but for
/// what its vertices are, which need not be points.
[[nodiscard]] Result<VerifyReport> verify_fine_point_tin(const PointTerrain& terrain,
                                                         const HeightPoints& fine,
                                                         const delaunay::Tin& tin, double max_error,
                                                         Threads threads, Progress& progress);

}  // namespace lode
