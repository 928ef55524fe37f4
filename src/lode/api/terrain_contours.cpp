#include <algorithm>
#include <new>
#include <utility>

#include "lode/api/terrain_tin_impl.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/tin_bands.h"
#include "lode/mappers/tin_contours.h"

namespace lode {

HeightRange TerrainTin::height_range() const {
  if (impl_->range) return *impl_->range;
  LODE_EXPECTS(!impl_->parts);
  const auto [lowest, highest] = std::ranges::minmax(impl_->tin.heights);
  return {lowest, highest};
}

Result<std::shared_ptr<const delaunay::Tin>> TerrainTin::Impl::tin_crossing(
    std::span<const double> heights, Progress& progress) const {
  if (!parts) return std::shared_ptr<const delaunay::Tin>(std::shared_ptr<void>(), &tin);
  LODE_TRY(std::optional<delaunay::Tin> near, parts->crossing(heights, progress));
  if (near) return std::make_shared<const delaunay::Tin>(*std::move(near));
  LODE_TRY(SelectedTerrain whole,
           terrain->origin().select(options, delaunay::TinLinks::kept, progress));
  return std::make_shared<const delaunay::Tin>(std::move(whole.tin));
}

Result<TerrainContours> TerrainTin::contours(std::span<const double> heights,
                                             Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(const auto tin, impl_->tin_crossing(heights, progress));
  LODE_TRY(ContourSet traced, trace_contours(*tin, heights, KeptLines::drawable, progress));
  TerrainContours contours;
  contours.n_points = traced.n_points;
  contours.n_left_out = traced.n_left_out;
  contours.lines.reserve(traced.lines.size());
  for (ContourLine& line : traced.lines) {
    // In place: what was a column and a row becomes x and y.
    for (Place& at : line.points) at = impl_->frame.world(at[0], at[1]);
    if (impl_->frame.is_mirrored()) std::ranges::reverse(line.points);
    contours.n_rings += static_cast<std::uint64_t>(line.is_ring);
    contours.lines.push_back({heights[line.level], line.is_ring, std::move(line.points)});
  }
  contours.seconds = watch.seconds();
  return contours;
} catch (const std::bad_alloc&) {
  return out_of_memory("trace contours");
}

Result<TerrainBands> TerrainTin::bands(std::span<const double> heights, Progress& progress) const
    try {
  LODE_EXPECTS(!impl_->parts);
  const Stopwatch watch;
  LODE_TRY(std::vector<BandPolygon> found, find_bands(impl_->tin, heights, progress));
  const HeightRange range = height_range();
  TerrainBands bands;
  bands.polygons.reserve(found.size());
  for (BandPolygon& polygon : found) {
    TerrainBands::Polygon made{polygon.band > 0 ? heights[polygon.band - 1] : range.lower,
                               polygon.band < heights.size() ? heights[polygon.band] : range.upper,
                               {}};
    for (Ring& ring : polygon.rings) {
      for (Place& at : ring) at = impl_->frame.world(at[0], at[1]);
      if (impl_->frame.is_mirrored()) std::ranges::reverse(ring);
      bands.n_points += ring.size();
      made.rings.push_back(std::move(ring));
    }
    bands.n_holes += made.rings.size() - 1;
    bands.polygons.push_back(std::move(made));
  }
  bands.seconds = watch.seconds();
  return bands;
} catch (const std::bad_alloc&) {
  return out_of_memory("find bands");
}

}  // namespace lode
