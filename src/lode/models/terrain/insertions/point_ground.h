#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// Scattered points, and the part of the plane that they are a terrain over.
struct PointGround {
  HeightFrame frame;
  HeightRange range;  ///< Of all heights.
  delaunay::PointSamples samples;
  /// Of points, turning left, constrained Delaunay: the base.
  std::span<const std::array<std::uint32_t, 3>> triangles;
  /// Edges of these that are to stay; those of the outline do, anyway.
  std::span<const std::array<std::uint32_t, 2>> lines;
  std::uint64_t n_left_out = 0;  ///< Points that are in no triangle.
};

/// A history of them before any is inserted. Fails on heights that check_heights() refuses.
[[nodiscard]] Result<History> begin_history(const PointGround& ground, Model model);

/// The base, cut along lines where they would not stay otherwise.
[[nodiscard]] delaunay::PointMesh make_mesh(const PointGround& ground, Model model);

/// Those of the lines that have a triangle on both sides, by the places that their ends have in
/// `nodes`. Sorted.
[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> lines_between(
    const PointGround& ground, std::span<const std::uint32_t> nodes);

}  // namespace lode::insertions
