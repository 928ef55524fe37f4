#pragma once

#include "lode/locate/tin_height.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"

namespace lode::quaternary_triangulation {

/// The height of a triangle that is wholly in the domain, linear between its corners, at the place
/// of it that is nearest to p (column and row), or, beside its longest side, at one near to that:
/// at a corner the sample's, exactly.
[[nodiscard]] TinHeight height_in(const SquareDomain& domain, const HalfSquare& triangle,
                                  const delaunay::Point& p);

}  // namespace lode::quaternary_triangulation
