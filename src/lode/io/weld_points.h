#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/vec.h"

namespace lode::io {

/// What points are made one.
struct WeldRule {
  double distance = 0;  ///< Finite, from 0 on.
  double values = 0;    ///< Largest difference in any component of any field.
};

/// Which points are one.
struct Weld {
  std::vector<std::uint32_t> ids;  ///< By point: the smallest of those it is one with.
  std::uint64_t n_welded = 0;
  std::uint64_t n_refused = 0;  ///< Close to others of too different values.
};

/// Goes through the points that are used, in their order: each becomes one with the smallest point
/// before it that stayed itself, is close enough and has the same values (NaN equals NaN), or stays
/// itself. Time grows with the number of points that stay apart at one place.
[[nodiscard]] Weld weld_points(std::span<const Vec3d> points, const std::vector<MeshField>& fields,
                               const std::vector<std::uint8_t>& is_used, const WeldRule& rule);

/// How many points are at the place of one before them.
[[nodiscard]] std::uint64_t count_coincident(std::span<const Vec3d> points);

}  // namespace lode::io
