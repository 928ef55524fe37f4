#pragma once

#include <algorithm>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/mappers/surface_edits.h"
#include "lode/mappers/zero_normals.h"

namespace lode {

/// What is done to any isosurface last: normals completed, cropped to a box, small pieces dropped,
/// turned round. `options`: of an extraction, or the same members.
template <typename Options>
Dropped finish_edits(const Options& options, Surface& surface) {
  fill_zero_normals(surface, options.threads);
  if (options.clip) {
    crop(surface, *options.clip);
    split_pinched_vertices(surface);
  }
  Dropped dropped;
  if (options.min_component > 1) dropped = drop_small_components(surface, options.min_component);
  if (options.orientation == Orientation::from_higher_values) flip_orientation(surface);
  return dropped;
}

/// Isovalues that the surface has nothing of.
inline std::vector<double> unmet_isovalues(const Surface& surface,
                                           const std::vector<double>& isovalues) {
  if (surface.is_empty()) return isovalues;
  std::vector<double> unmet;
  // Without the attribute the vertices cannot be told apart; then only one isovalue was asked for.
  if (surface.isovalues.empty()) return unmet;
  for (const double isovalue : isovalues)
    if (std::ranges::find(surface.isovalues, isovalue) == surface.isovalues.end())
      unmet.push_back(isovalue);
  return unmet;
}

}  // namespace lode
