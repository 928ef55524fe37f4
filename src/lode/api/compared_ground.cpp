#include "lode/api/compared_ground.h"

#include "lode/delaunay/grid_domain.h"
#include "lode/mappers/point_errors.h"

namespace lode {

const HeightFrame& ComparedGround::frame() const {
  if (points_ != nullptr) return points_->points;
  return *grid_;
}

HeightRange ComparedGround::range() const {
  return points_ != nullptr ? height_range(points_->points) : height_range(*grid_);
}

std::uint64_t ComparedGround::n_samples() const {
  if (points_ != nullptr) return points_->points.nodes.size() - points_->domain.n_left_out;
  return static_cast<std::uint64_t>(grid_->n_samples()) - grid_->n_missing();
}

Result<void> ComparedGround::check() const {
  if (points_ != nullptr || delaunay::find_domain(*grid_)) return {};
  return fail("expected a cell with four heights, got none of {} x {} samples", grid_->n_columns,
              grid_->n_rows);
}

Result<void> ComparedGround::prepare(TerrainCandidate& model, std::span<const double> tolerances,
                                     Threads threads, Progress& progress) const {
  return points_ != nullptr ? model.prepare_points(*points_, tolerances, threads, progress)
                            : model.prepare(*grid_, tolerances, threads, progress);
}

TinQuality ComparedGround::quality(const delaunay::Tin& tin, std::int32_t scale,
                                   Threads threads) const {
  return points_ != nullptr ? measure_point_quality(tin, scale, points_->points, threads)
                            : measure_quality(tin, scale, *grid_, threads);
}

Result<BuiltTerrain> ComparedGround::build(const TerrainBuildOptions& options,
                                           Progress& progress) const {
  return points_ != nullptr ? BuiltTerrain::build(*points_, options, progress)
                            : BuiltTerrain::build(*grid_, options, progress);
}

}  // namespace lode
