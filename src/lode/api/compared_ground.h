#pragma once

#include <cstdint>
#include <span>

#include "lode/api/built_terrain.h"
#include "lode/api/compared_terrain.h"
#include "lode/api/point_terrain.h"
#include "lode/core/height_grid.h"
#include "lode/mappers/tin_quality.h"

namespace lode {

/// What models are compared on: a raster, or scattered points; whichever it is outlives it.
class ComparedGround {
 public:
  explicit ComparedGround(const HeightGrid& grid) : grid_(&grid) {}
  explicit ComparedGround(const PointTerrain& points) : points_(&points) {}

  [[nodiscard]] bool is_of_points() const { return points_ != nullptr; }
  /// Of the raster, or of the points' lattice.
  [[nodiscard]] const HeightFrame& frame() const;
  [[nodiscard]] HeightRange range() const;
  /// With a height; of points those of the domain.
  [[nodiscard]] std::uint64_t n_samples() const;
  /// Fails where it has no domain.
  [[nodiscard]] Result<void> check() const;

  [[nodiscard]] Result<void> prepare(TerrainCandidate& model, std::span<const double> tolerances,
                                     Threads threads, Progress& progress) const;
  [[nodiscard]] TinQuality quality(const delaunay::Tin& tin, std::int32_t scale,
                                   Threads threads) const;
  [[nodiscard]] Result<BuiltTerrain> build(const TerrainBuildOptions& options,
                                           Progress& progress) const;

 private:
  const HeightGrid* grid_ = nullptr;
  const PointTerrain* points_ = nullptr;
};

}  // namespace lode
