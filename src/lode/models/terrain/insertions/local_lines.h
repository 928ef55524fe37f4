#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/insertions/history_file.h"
#include "lode/models/terrain/insertions/tolerance_steps.h"

namespace lode::insertions {

/// Of the mesh at a time of a file that is worst first, the triangles that have one of some
/// heights, which rise strictly, at a corner or between, and others; in the order of the whole
/// mesh's, with twins among each other and errors. Only what may become such a triangle is refined
/// (docs/models/delaunay_pyramid.md). Nothing where that takes more than so many nodes.
[[nodiscard]] Result<std::optional<delaunay::Tin>> tin_crossing(const HistoryFile& file,
                                                                std::uint32_t time,
                                                                std::span<const double> heights,
                                                                std::uint32_t max_nodes,
                                                                Progress& progress);

/// The nodes that tin_crossing() may be expected to take, of the file's range and steps alone: not
/// a bound.
[[nodiscard]] double expected_crossing(const HistoryFile& file, std::uint32_t time,
                                       std::span<const double> heights);

/// Of the vertices of such a mesh, from the pages near the outermost. Nothing where that takes more
/// than so many nodes.
[[nodiscard]] Result<std::optional<HeightRange>> height_range(const HistoryFile& file,
                                                              std::uint32_t time,
                                                              std::uint32_t max_nodes,
                                                              Progress& progress);

}  // namespace lode::insertions
