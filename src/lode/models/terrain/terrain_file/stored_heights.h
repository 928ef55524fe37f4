#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/models/terrain/terrain_file/columns.h"
#include "lode/store/bytes.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"

namespace lode::terrain_file {

/// The type that a column of vertices' heights has in a file; its number there.
enum class StoredHeight : std::uint8_t { int16 = 1, float32 = 2, float64 = 3 };

/// The narrowest type that holds all heights exactly.
[[nodiscard]] StoredHeight narrowest(std::span<const double> heights);

/// Fails, naming the path, where it is none.
[[nodiscard]] Result<StoredHeight> read_stored_height(store::ByteReader& in,
                                                      const std::string& path);

/// All heights, which the type holds.
[[nodiscard]] Result<void> append_heights(const ColumnKey& column, StoredHeight type,
                                          std::span<const double> heights, store::Writer& writer);

/// n heights. Fails, naming the file, where one is out of the range.
[[nodiscard]] Result<std::vector<double>> read_heights(const store::Reader& reader,
                                                       const ColumnKey& column, StoredHeight type,
                                                       std::uint64_t n, const HeightRange& range);

}  // namespace lode::terrain_file
