#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/surface_band.h"
#include "lode/mappers/surface_edits.h"

namespace lode {

struct BandComponents {
  ComponentNumbers numbers;
  std::vector<std::uint8_t> may_go;  ///< By component.
};

/// Closed components that hold no sample outside the band may go: what is inside them, which
/// changes sides, is within it. Whether they do is asked of the tetrahedra from one point to their
/// triangles, which hold all that is inside and, of others than star-shaped ones, more; one with
/// another that stays in its box stays, too. For surfaces of triangles; fails when cancelled.
[[nodiscard]] Result<BandComponents> find_components_in_band(const Surface& surface,
                                                             const SurfaceBand& band,
                                                             Threads threads, Progress& progress);

/// Drops those. Expects no errors per cell.
[[nodiscard]] Result<Dropped> drop_components_in_band(Surface& surface, const SurfaceBand& band,
                                                      Threads threads, Progress& progress);

}  // namespace lode
