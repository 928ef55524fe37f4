#pragma once

#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// Rings of places in the plane, closed or not: what an odd number of them holds is inside, so that
/// inner rings are holes, whichever way they turn.
using PlacePolygon = std::vector<std::vector<Vec<double, 2>>>;

}  // namespace lode
