#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// The model's name in files, as that of the enumerator.
[[nodiscard]] std::string_view model_name(Model model);

/// A history, and the tolerances that it was made for: each finer than the one before; of an
/// implicit pyramid none.
struct LevelledHistory {
  History history;
  std::vector<double> levels;
};

/// Writes it as docs/format.md says, whole or not at all. No triangle but the base's is in
/// the file: the vertices in their order make them again. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const LevelledHistory& levelled, const std::string& path,
                                         Progress& progress);

/// Whether a file is a .lode file of these models; also false where it cannot be read.
[[nodiscard]] bool is_model_of(const std::string& path);

/// Reads all of it and inserts the vertices again, with exact predicates: whatever the file says,
/// they make a triangulation, Delaunay where that is the rule. Fails on all that is not as
/// docs/format.md says, naming the file and what was expected.
[[nodiscard]] Result<LevelledHistory> open(const std::string& path, Progress& progress);

}  // namespace lode::insertions
