#pragma once

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/surface_band.h"
#include "lode/mappers/surface_edits.h"

namespace lode {

/// Drops closed components that hold no sample outside the band: what is inside them, which changes
/// sides, is within it. Whether they do is asked of the tetrahedra from one point to their
/// triangles, which hold all that is inside and, of others than star-shaped ones, more; one with
/// another that stays in its box stays, too. For surfaces of triangles without errors; fails when
/// cancelled.
[[nodiscard]] Result<Dropped> drop_components_in_band(Surface& surface, const SurfaceBand& band,
                                                      Threads threads, Progress& progress);

}  // namespace lode
