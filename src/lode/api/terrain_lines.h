#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "lode/api/point_terrain.h"
#include "lode/api/terrain_source.h"
#include "lode/core/height_grid.h"
#include "lode/core/place_line.h"
#include "lode/models/terrain/terrain_features/features.h"

namespace lode {

/// Lines that every TIN of a terrain is to have among its edges, whatever the tolerance.
struct TerrainLineOptions {
  /// Critical points of at least this relief (>= 0, units of the heights) and the ridges and
  /// channels between them: see docs/models/terrain_features.md.
  std::optional<double> least_relief{};
  std::vector<PlaceLine> breaklines{};  ///< In the terrain's coordinates.
  std::uint64_t n_points = 0;           ///< That their file has beside them: for the report.
  bool is_draped = false;  ///< Breaklines get the surface's heights, though they have their own.
  double drape_error = 0;  ///< >= 0: draped lines stay that near to the surface.
};

struct TerrainLineReport {
  double least_relief = 0;                                        ///< Where there are features.
  std::optional<terrain_features::FeatureCounts> all_features{};  ///< Whatever their relief.
  std::optional<terrain_features::FeatureCounts> kept_features{};
  std::uint64_t n_ridges = 0;
  std::uint64_t n_channels = 0;
  std::uint64_t n_breaklines = 0;
  std::uint64_t n_points = 0;       ///< Of their file, left out as they are no lines.
  std::uint64_t n_own_heights = 0;  ///< Breaklines whose heights are kept.
  double drape_error = 0;           ///< Of the others: see TerrainLineOptions.
  std::uint64_t n_outside = 0;      ///< Breaklines no part of which is in the domain.
  std::uint64_t n_cut = 0;          ///< Those that end at its outline.
  std::uint64_t n_crossing = 0;     ///< Edges left out as they cross the outline after rounding.
  std::uint64_t n_replaced = 0;     ///< Samples whose heights are a breakline's now.
  double largest_change = 0;        ///< Of such a height.
  /// Places where breaklines with heights of their own meet at different ones, and get their mean;
  std::uint64_t n_unequal = 0;
  double largest_spread = 0;  ///< and between how far apart.
  double largest_move = 0;    ///< Of a vertex of a breakline, in units of the world.
  std::uint64_t n_edges = 0;  ///< In the coarsest TIN.
  double seconds = 0;
};

/// A terrain with lines: its samples and the lines' vertices as scattered points.
struct LinedTerrain {
  PointTerrain terrain;
  TerrainLineReport report;
};

/// The samples that features of a raster run through, and critical points, in rows: what models on
/// squares can keep of them. Fails as add_lines().
[[nodiscard]] Result<std::vector<LatticePoint>> find_feature_nodes(const HeightGrid& grid,
                                                                   double least_relief,
                                                                   TerrainLineReport& report,
                                                                   Progress& progress);

/// Of a raster: its samples in cells with four heights are points of a lattice, with breaklines
/// 1024 times finer or as fine as fits. Fails as select_samples() does, where lines cannot be taken
/// together, and when cancelled. About 150 bytes a sample.
[[nodiscard]] Result<LinedTerrain> add_lines(const HeightGrid& grid,
                                             const TerrainLineOptions& options, Progress& progress);

/// Of scattered points, on whose lattice breaklines are put.
[[nodiscard]] Result<LinedTerrain> add_lines(PointTerrain terrain,
                                             const TerrainLineOptions& options, Progress& progress);

}  // namespace lode
