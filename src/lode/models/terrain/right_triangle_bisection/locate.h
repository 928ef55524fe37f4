#pragma once

#include <cstdint>
#include <optional>

#include "lode/delaunay/window.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"

namespace lode::bisection {

/// A triangle of a mesh, between samples; corners turn left.
struct MeshTriangle {
  delaunay::LatticeCorners corners;
  float error = 0;  ///< As of Tin::errors.
};

/// The triangle of tin_within() that holds a place in columns and rows, found from above without
/// the mesh in O(log n); of several that do one. Nothing outside of the domain.
[[nodiscard]] std::optional<MeshTriangle> find_triangle(const Bisection& bisection,
                                                        double tolerance, double x, double y);

/// Of its plane at a place in it; samples in it are not farther from that than its error.
[[nodiscard]] double height_in(const MeshTriangle& triangle, const HeightGrid& grid, double x,
                               double y);

/// How many triangles of tin_within() meet a window: O(log n) and what is counted.
[[nodiscard]] std::uint64_t count_in_window(const Bisection& bisection, double tolerance,
                                            const delaunay::Window& window);

}  // namespace lode::bisection
