#pragma once

#include "lode/api/dataset.h"
#include "lode/mappers/surface_edits.h"

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

}  // namespace lode
