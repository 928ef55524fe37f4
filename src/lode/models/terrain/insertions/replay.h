#pragma once

#include <cstddef>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history_file.h"

namespace lode::insertions {

/// The history up to where the first bands of a file end: reads their pages and inserts their nodes
/// again, in their order, with exact predicates. Triangles that later nodes remove live on. Fails,
/// naming the file, where a node cannot be inserted or makes another number of triangles than the
/// file says.
[[nodiscard]] Result<History> replay(const HistoryFile& file, std::size_t n_bands,
                                     Progress& progress);

}  // namespace lode::insertions
