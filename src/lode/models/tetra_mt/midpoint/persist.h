#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/persist.h"

namespace lode::tetra_mt::midpoint {

/// The model's name in files.
inline constexpr std::string_view kModelName = "tetra_mt_midpoint";

/// A hierarchy whose pages come from a file.
struct OpenedForest {
  Forest forest;
  /// Hierarchy's; labels of leaves, each once.
  std::function<Result<std::vector<std::uint32_t>>()> coincident_leaves;
  std::function<FileReads()> reads;
};

/// Writes a hierarchy as docs/format.md says, whole or not at all. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const Hierarchy& hierarchy, const std::string& path,
                                         Threads threads, Progress& progress);

/// Whether a file is a .lode file of this model; also false where it cannot be read.
[[nodiscard]] bool is_model_of(const std::string& path);

/// Reads what is there from the beginning, the base and the table of pages; pages are read when
/// they are looked at. Fails on all that is not as docs/format.md says, naming the file and what
/// was expected.
[[nodiscard]] Result<OpenedForest> open(const std::string& path);

}  // namespace lode::tetra_mt::midpoint
