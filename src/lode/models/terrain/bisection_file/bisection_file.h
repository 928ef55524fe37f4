#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "lode/models/terrain/terrain_file/source.h"

namespace lode::bisection_file {

/// Bisected right triangles with the raster that they are of.
struct BisectionModel {
  terrain_file::Source source;
  std::vector<double> levels;  ///< Each finer than the one before.
  HeightGrid grid;
  bisection::Bisection tree;
};

/// Writes all heights and what is kept, as docs/format.md says, whole or not at all. No errors:
/// they are found again in less time than reading them takes. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const BisectionModel& model, const std::string& path,
                                         Progress& progress);

/// Reads all of it and finds all errors. Fails on all that is not as docs/format.md says, naming
/// the file and what was expected, and when cancelled.
[[nodiscard]] Result<BisectionModel> open(const std::string& path, Threads threads,
                                          Progress& progress);

}  // namespace lode::bisection_file
