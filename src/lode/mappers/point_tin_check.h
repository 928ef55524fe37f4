#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/core/height_points.h"
#include "lode/core/parallel.h"
#include "lode/core/placed_surface.h"
#include "lode/core/progress.h"
#include "lode/delaunay/tin.h"
#include "lode/mappers/tin_check.h"

namespace lode {

/// check_tin() of scattered points: holds a surface against them by squares of points and the signs
/// of areas. A vertex is at a point where floats explain the distance; of several the one whose
/// height is nearest. `outline`: edges of the domain, by numbers of points, the domain on their
/// left; `lines`: edges that are to be edges of triangles, cut where points lie on them, and need
/// not be Delaunay; `n_samples`: how many points are in the domain. Errors are computed in 64 bits
/// of mantissa, and what that rounds is allowed. `worst` of what is found is a node of the points'
/// lattice.
/// `Mesh`: PlacedSurfaceView; or delaunay::Tin, which has places and heights as they are, so that
/// nothing is allowed for floats.
template <typename Mesh>
[[nodiscard]] Result<TinFacts> check_point_tin(
    const Mesh& mesh, const HeightPoints& points,
    std::span<const std::array<std::uint32_t, 2>> outline,
    std::span<const std::array<std::uint32_t, 2>> lines, std::uint64_t n_samples, double max_error,
    Threads threads, Progress& progress);

/// The same of a TIN with heights whose vertices need not be points; both on one lattice.
[[nodiscard]] Result<TinFacts> check_fine_point_tin(
    const delaunay::Tin& tin, const HeightPoints& points,
    std::span<const std::array<std::uint32_t, 2>> outline,
    std::span<const std::array<std::uint32_t, 2>> lines, std::uint64_t n_samples, double max_error,
    Threads threads, Progress& progress);

}  // namespace lode
