#pragma once

#include <cstdint>

#include "lode/delaunay/tin.h"

namespace lode {

/// How many vertices on two columns that are one place, as they are of a raster that goes round the
/// earth, have no twin there: they lie in an edge of the other column, so that the surface has a
/// crack. A vertex beside a gap of the other column has nothing to meet, and does not count. Of a
/// TIN whose triangles lie between the columns. O(triangles), and what sorting those on the columns
/// takes.
[[nodiscard]] std::uint64_t count_one_sided(const delaunay::Tin& tin, std::int32_t first_column,
                                            std::int32_t last_column);

}  // namespace lode
