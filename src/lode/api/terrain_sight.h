#pragma once

#include <cstdint>
#include <optional>

#include "lode/api/terrain_tin.h"
#include "lode/locate/line_of_sight.h"

namespace lode {

/// once: at the tolerance asked for. until_decided: where that leaves it undecided, also at the
/// finest that there is, and where all heights are at hand (TerrainOptions::samples) at 0.
enum class SightEffort : std::uint8_t { once, until_decided };

struct TerrainSightOptions {
  Place from;
  Place to;
  double observer_height = 1.8;  ///< Above the terrain, in the unit of its heights; >= 0.
  double target_height = 0;
  /// Of light by air, as a share of the earth's curvature; <= 1, which makes the earth flat.
  double refraction = 0.13;
  SightEffort effort = SightEffort::once;
  /// Of a unit of heights, instead of what the grid says.
  std::optional<double> vertical_metres{};
};

/// Whether two places see each other, and why. Heights in the unit of the terrain's.
struct TerrainSight {
  SightVerdict verdict = SightVerdict::undecided;
  bool has_gap = false;       ///< On the way; then nothing is visible.
  double distance = 0;        ///< Of the places, as the metric has it.
  Place at;                   ///< Of the obstruction, or where the terrain is nearest to the ray.
  double at_distance = 0;     ///< From the observer.
  double terrain_height = 0;  ///< There, of the TIN.
  /// By how much the terrain stands above the ray there, at least and at most; below 0: under it.
  double above_low = 0;
  double above_high = 0;
  double radius = 0;           ///< Of the earth, metres.
  double vertical_metres = 0;  ///< Of a unit of the heights.
  /// Else it is assumed (HorizontalMetric::assumed_height_unit()).
  bool is_vertical_unit_known = false;
  std::uint32_t n_rounds = 1;  ///< TINs that were made.
  double finest_error = 0;     ///< The least tolerance that there is.
  TerrainReport terrain;       ///< Of the last.
  double seconds = 0;          ///< Of all.

  /// Whether no finer TIN can be asked.
  [[nodiscard]] bool is_finest() const { return terrain.max_error <= finest_error; }
};

/// The segment is straight in the terrain's coordinates. Fails where one of the places is not on
/// the terrain, as TerrainTin::select() does, and when cancelled.
[[nodiscard]] Result<TerrainSight> find_terrain_sight(const Terrain& terrain,
                                                      const TerrainOptions& tin_options,
                                                      const HorizontalMetric& metric,
                                                      const TerrainSightOptions& options,
                                                      Progress& progress);

}  // namespace lode
