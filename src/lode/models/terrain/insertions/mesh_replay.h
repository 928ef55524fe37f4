#pragma once

#include <cstddef>
#include <cstdint>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/insertions/history_file.h"

namespace lode::insertions {

/// tin_at() of a file's history, with twins and errors, without making the history: nodes before
/// the time are inserted square by square, but for those that would come before others they depend
/// on, or that depend on them (docs/models/delaunay_pyramid.md). Fails, naming the file, where a
/// page is not as it has to be or a node cannot be inserted, and when cancelled.
/// n_in_square: about so many nodes of a band come in a square; it changes nothing but the time.
inline constexpr std::size_t kNodesInSquare = std::size_t{1} << 14;
[[nodiscard]] Result<delaunay::Tin> tin_at(const HistoryFile& file, std::uint32_t time,
                                           Progress& progress,
                                           std::size_t n_in_square = kNodesInSquare);

}  // namespace lode::insertions
