#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/squares/square_domain.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"
#include "lode/models/terrain/terrain_file/source.h"

namespace lode::quadtree_file {

using quaternary_triangulation::QuaternaryTriangulation;
using squares::SquareDomain;
using surface_quadtree::SurfaceQuadtree;

/// A model on squares with the raster that it is of. A restricted quadtree is made for each
/// tolerance, so that it has no more than its domain.
struct QuadtreeModel {
  terrain_file::Source source;
  std::vector<double> levels;  ///< Each finer than the one before.
  HeightGrid grid;
  std::variant<SurfaceQuadtree, QuaternaryTriangulation, SquareDomain> tree;
};

[[nodiscard]] const SquareDomain& domain_of(const QuadtreeModel& model);

/// The model's name in files: that of the room that it is of.
[[nodiscard]] std::string_view model_name(const QuadtreeModel& model);

/// Writes all heights, what is kept, and all errors but of restricted quadtrees, as docs/format.md
/// says, whole or not at all. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const QuadtreeModel& model, const std::string& path,
                                         Progress& progress);

/// Reads all of it. Fails on all that is not as docs/format.md says, naming the file and what was
/// expected. Errors are not found again: what they are is for verification to say.
[[nodiscard]] Result<QuadtreeModel> open(const std::string& path, Progress& progress);

}  // namespace lode::quadtree_file
