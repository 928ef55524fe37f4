#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"

namespace lode::bench {

/// What Martini (the npm package @mapbox/martini, right triangles bisected, in JavaScript) took for
/// a raster, warm: medians.
struct MartiniTimes {
  struct Mesh {
    double ms = 0;
    std::uint64_t n_triangles = 0;
    double true_error = 0;  ///< At all samples, measured here: Martini's own are no bounds.
  };
  double errors_ms = 0;
  std::vector<Mesh> meshes{};  ///< By tolerance.
};

/// Runs `node` on the package in the folder that LODE_MARTINI names. A raster is continued to
/// 2^n + 1 samples a side by its last row and column. Fails, beginning with "skipped", where there
/// is no package or no node.
[[nodiscard]] Result<MartiniTimes> time_martini(const HeightGrid& grid,
                                                const std::vector<double>& tolerances, int n_runs);

}  // namespace lode::bench
