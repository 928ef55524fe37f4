#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "lode/store/directory.h"

namespace lode::store {

/// A file of which only the blocks' indexes are looked at.
struct IndexedFile {
  std::string path;
  std::uint64_t size = 0;
  std::uint64_t memory_limit = 0;  ///< For all entries that are found, and for a decoded index.
  /// Fills `out` from an offset; all of it lies in the file.
  std::function<Result<void>(std::uint64_t, std::span<std::byte>)> read_at;
};

/// The directory as far as indexes that are whole say it, in the order of the file; without blocks
/// where none is. An index counts where it says that it lies; what it says lies behind it is not
/// searched for others. Those of another model or other metadata than the first, and keys that were
/// there already, are left out. Blocks may reach beyond the end of the file. Reads each byte at
/// most three times, a mebibyte at once.
[[nodiscard]] Directory scan_indexes(const IndexedFile& file);

}  // namespace lode::store
