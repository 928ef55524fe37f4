#pragma once

#include <array>

#include "lode/core/vec.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// Values that count as one another's where distances are asked for, as a share of the field's
/// range: what rounding of data and codes, or noise far below all that matters, takes away is not
/// lost.
inline constexpr double kSameValue = 0x1p-20;

/// How far from `p` a tetrahedron has a value of the linear function that its corners' values
/// make, in the unit of the corners; infinite where it has it nowhere. Of all cells of a mesh the
/// least is the distance of which the space error is the largest (Cignoni, De Floriani, Magillo,
/// Puppo, Scopigno 2004, section 3).
[[nodiscard]] double distance_to_value(const std::array<Vec3d, 4>& corners,
                                       const std::array<double, 4>& values, double value,
                                       const Vec3d& p);

/// The same of a range of values, which may be one.
[[nodiscard]] double distance_to_values(const std::array<Vec3d, 4>& corners,
                                        const std::array<double, 4>& values, const Range& range,
                                        const Vec3d& p);

}  // namespace lode::tetra_mt
