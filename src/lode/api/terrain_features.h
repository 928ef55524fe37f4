#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/api/terrain_source.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/models/terrain/terrain_features/features.h"

namespace lode {

/// Critical points of a terrain's surface of all samples, and the ridges and channels between them
/// as a network (docs/models/terrain_features.md). Places are x, y of the world and the height.
struct TerrainFeatures {
  struct Point {
    terrain_features::CriticalKind kind = terrain_features::CriticalKind::pit;
    std::uint32_t multiplicity = 1;  ///< Of a pass: how many of its pairs are kept.
    double relief = 0;               ///< Units of the heights; infinite without a pair.
    bool is_on_outline = false;      ///< Of the domain, which has an outline round gaps, too.
    Vec3d at;
  };
  /// A stretch between junctions: it ends at critical points that are kept, on the outline, or
  /// where others of its kind do; no edge of the surface is in two of one kind.
  struct Line {
    terrain_features::LineKind kind = terrain_features::LineKind::ridge;
    double relief = 0;  ///< The largest of the passes that lead over it; infinite as theirs.
    std::vector<Vec3d> points;  ///< Samples, from the pass that leads over it on.
  };

  std::vector<Point> points;  ///< Kept ones, in rows.
  std::vector<Line> lines;    ///< Of passes of large relief first, ridges before channels.
  double least_relief = 0;
  terrain_features::FeatureCounts all;
  terrain_features::FeatureCounts kept;
  /// Of the surface: vertices - edges + triangles, which is peaks - passes + pits, of all and kept.
  std::int64_t euler_number = 0;
  std::uint64_t n_triangles = 0;
  std::uint64_t n_ridges = 0;  ///< Lines, and so the next one.
  std::uint64_t n_channels = 0;
  std::uint64_t n_line_points = 0;
  double select_seconds = 0;  ///< Making the surface.
  double find_seconds = 0;
};

/// 1 % of a range of heights, 0 where there is none.
[[nodiscard]] double default_relief(const HeightRange& range);

/// Of at least this relief (>= 0, units of the heights); without: default_relief(). Of rasters,
/// scattered points, and models that keep all heights. Fails on others, where no cell of a raster
/// has four heights, and when cancelled. Some 150 bytes a sample.
[[nodiscard]] Result<TerrainFeatures> find_terrain_features(const Terrain& terrain,
                                                            std::optional<double> least_relief,
                                                            Progress& progress);

}  // namespace lode
