#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/insertions/history_file.h"
#include "lode/refine/demand.h"

namespace lode::insertions {

/// tin_of() what select_nodes() has of a file's history, from the pages that it takes: with errors
/// and, if `links` says so, twins. Nothing where it is more than so many nodes: replaying all takes
/// a third of the time a node. Fails when cancelled, and where a page is not as it has to be.
[[nodiscard]] Result<std::optional<delaunay::Tin>> select_tin(const HistoryFile& file,
                                                              const Demand& demand,
                                                              delaunay::TinLinks links,
                                                              std::uint32_t max_nodes,
                                                              Progress& progress);

/// Of the mesh at a time, the triangles that hold some places (columns and rows), with their edges,
/// in the order of the whole mesh's, with twins among each other and errors. From the pages near
/// the places.
[[nodiscard]] Result<delaunay::Tin> tin_around(const HistoryFile& file, std::uint32_t time,
                                               std::span<const delaunay::Point> places,
                                               Progress& progress);

/// The same of those that a segment meets, and perhaps of some beside it.
[[nodiscard]] Result<delaunay::Tin> tin_along(const HistoryFile& file, std::uint32_t time,
                                              const delaunay::Point& a, const delaunay::Point& b,
                                              Progress& progress);

/// The same of those that meet a rectangle, and of some beside it. Nothing where that takes more
/// than so many nodes.
[[nodiscard]] Result<std::optional<delaunay::Tin>> tin_within(
    const HistoryFile& file, std::uint32_t time, const delaunay::Point& lower,
    const delaunay::Point& upper, std::uint32_t max_nodes, Progress& progress);

}  // namespace lode::insertions
