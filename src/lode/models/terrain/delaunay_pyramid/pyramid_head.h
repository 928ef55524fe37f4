#pragma once

#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"
#include "lode/store/reader.h"

namespace lode::delaunay_pyramid {

/// Fails, naming the file, on what docs/format.md does not allow.
[[nodiscard]] Result<PyramidHead> read_head(const store::Reader& reader);

}  // namespace lode::delaunay_pyramid
