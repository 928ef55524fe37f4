#pragma once

#include <cstdint>

#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// The height of a TIN at a place, and by how much rounding may have put it off.
struct TinHeight {
  double height = 0;
  double rounding = 0;
};

/// Of a TIN with heights, in the plane of a triangle that holds p: at a corner the sample's,
/// exactly. In float64.
[[nodiscard]] TinHeight height_in(const delaunay::Tin& tin, std::uint32_t triangle,
                                  const delaunay::Point& p);

}  // namespace lode
