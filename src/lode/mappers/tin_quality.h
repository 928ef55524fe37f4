#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "lode/core/height_grid.h"
#include "lode/core/lattice_point.h"
#include "lode/core/parallel.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// How triangles are shaped: by their smallest angles, in the raster's coordinates.
struct TinAngles {
  std::array<std::uint64_t, 12> counts{};  ///< In steps of 5 degrees.
  double smallest = 0;                     ///< Degrees; 0 without triangles.
  double median = 0;
};

/// Of a TIN in a frame, or in one whose columns and rows are several nodes of the TIN's apart.
[[nodiscard]] TinAngles measure_angles(const delaunay::Tin& tin, const HeightFrame& frame,
                                       Threads threads);

/// The largest |z - z'| of the samples in a triangle of a TIN with heights; else as
/// measure_quality().
[[nodiscard]] double worst_error_in(const delaunay::Tin& tin, std::size_t triangle,
                                    std::int32_t scale, const HeightGrid& grid);

/// visit(column and row, |z - z'|) of those samples; else the same.
void visit_errors_in(const delaunay::Tin& tin, std::size_t triangle, std::int32_t scale,
                     const HeightGrid& grid,
                     const std::function<void(LatticePoint, double)>& visit);

/// How good a TIN is as an approximation of a grid of heights, and how its triangles are shaped.
struct TinQuality {
  std::uint64_t n_samples = 0;    ///< With a height, in some triangle.
  std::uint64_t n_uncovered = 0;  ///< With one, in none.
  double worst_error = 0;         ///< |z - z'| of those covered, rounded up.
  double rms_error = 0;
  TinAngles angles{};
};

/// The TIN has heights, turns left, and lies in the grid, whose columns and rows are `scale` nodes
/// of the TIN's lattice apart: so its vertices may lie between samples. A sample on an edge counts
/// once, by the larger of its errors, computed in 64 bits of mantissa from differences of heights.
/// The same for any number of threads. Takes 8 bytes a sample.
[[nodiscard]] TinQuality measure_quality(const delaunay::Tin& tin, std::int32_t scale,
                                         const HeightGrid& grid, Threads threads);

}  // namespace lode
