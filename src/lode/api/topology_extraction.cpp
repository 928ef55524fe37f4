#include "lode/api/topology_extraction.h"

#include <cmath>

namespace lode {

Result<void> check_keep_topology(const ExtractOptions& options) {
  if (!options.keep_topology) return {};
  if (!(*options.keep_topology >= 0 && std::isfinite(*options.keep_topology)))
    return fail("keep_topology: expected a finite persistence >= 0, got {}",
                *options.keep_topology);
  if (options.clip)
    return fail(
        "keep_topology: expected no clip box with it, which cuts another surface elsewhere");
  if (options.min_component > 1)
    return fail("keep_topology: expected all pieces kept with it, got min_component {}",
                options.min_component);
  return {};
}

bool leaves_out_weak(const ExtractOptions& options) {
  return options.keep_topology.value_or(0) > 0 && options.leaves_out_weak && !options.max_distance;
}

void begin_topology(const ExtractOptions& options, ExtractReport& report) {
  if (!options.keep_topology) return;
  report.topology =
      KeptTopology{.persistence = *options.keep_topology,
                   .is_searched = report.max_error > 0 && options.style == SurfaceStyle::tetra,
                   .leaves_out_weak = leaves_out_weak(options)};
}

}  // namespace lode
