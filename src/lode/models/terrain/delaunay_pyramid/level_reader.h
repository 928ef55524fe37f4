#pragma once

#include <cstddef>
#include <cstdint>

#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"
#include "lode/store/reader.h"

namespace lode::delaunay_pyramid {

enum class ReadLinks : std::uint8_t { no, yes };

/// Each fills in what its name says of a pyramid that knows its head, and fails, naming the file,
/// on numbers that docs/format.md does not allow; blocks are there before memory is asked for.

/// Places and heights of vertices until a level, not including it.
[[nodiscard]] Result<void> read_vertices(const store::Reader& reader, std::size_t end_level,
                                         Pyramid& pyramid);
[[nodiscard]] Result<void> read_lines(const store::Reader& reader, Pyramid& pyramid);
/// What is kept with a level, whose vertices were read. Neighbours are not looked at.
[[nodiscard]] Result<void> read_level(const store::Reader& reader, std::size_t level,
                                      ReadLinks links, Pyramid& pyramid);

}  // namespace lode::delaunay_pyramid
