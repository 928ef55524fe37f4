#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lode/core/vec.h"

namespace lode::simplification {

/// A triangle, or a piece that it is cut into.
using Piece = std::array<Vec3d, 3>;

inline constexpr double kUnproven = std::numeric_limits<double>::infinity();
// Corners are floats, and differences, midpoints and squared distances are found in doubles: with
// coordinates up to 2^24 of the limit this covers their rounding many times over.
inline constexpr double kRounding = 1e-6;

[[nodiscard]] inline Piece widened_corners(const std::array<Vec3f, 3>& t) {
  return {widened(t[0]), widened(t[1]), widened(t[2])};
}

[[nodiscard]] inline std::array<Piece, 4> quarters(const Piece& p) {
  const Vec3d a = (p[1] + p[2]) * 0.5;
  const Vec3d b = (p[2] + p[0]) * 0.5;
  const Vec3d c = (p[0] + p[1]) * 0.5;
  return {Piece{p[0], c, b}, Piece{c, p[1], a}, Piece{b, a, p[2]}, Piece{a, b, c}};
}

/// visit(part) for parts of a piece until it is false; whether it never was: halves of a piece much
/// longer than wide, whose quarters would be as long, else quarters.
template <typename Visit>
bool for_each_part(const Piece& p, const Visit& visit) {
  constexpr double kMostAspect = 4;
  std::array<double, 3> edge2{};  // of the edges opposite to the corners
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d edge = p[(i + 2) % 3] - p[(i + 1) % 3];
    edge2[i] = dot(edge, edge);
  }
  const auto longest =
      static_cast<std::size_t>(std::max_element(edge2.begin(), edge2.end()) - edge2.begin());
  const Vec3d& a = p[longest];
  const Vec3d& b = p[(longest + 1) % 3];
  const Vec3d& c = p[(longest + 2) % 3];
  const Vec3d normal = cross(b - a, c - a);
  // The height on the longest edge is the length of this by that of the edge.
  if (dot(normal, normal) * kMostAspect * kMostAspect < edge2[longest] * edge2[longest]) {
    const Vec3d middle = (b + c) * 0.5;
    return visit(Piece{a, b, middle}) && visit(Piece{a, middle, c});
  }
  const auto parts = quarters(p);
  return std::all_of(parts.begin(), parts.end(), visit);
}

[[nodiscard]] inline double radius_of(const Piece& piece) {
  const Vec3d middle = (piece[0] + piece[1] + piece[2]) * (1.0 / 3);
  double radius2 = 0;
  for (const Vec3d& corner : piece)
    radius2 = std::max(radius2, dot(corner - middle, corner - middle));
  return std::sqrt(radius2);
}

/// Of the n * n congruent cells of a triangle, row by row from its first corner.
[[nodiscard]] inline Piece cell_of(const Piece& t, std::size_t cell, std::size_t n) {
  std::size_t row = 0;
  while ((row + 1) * (row + 1) <= cell) ++row;
  const std::size_t at = cell - row * row;  // of 2 row + 1, every second one upside down
  const auto point = [&](std::size_t r, std::size_t c) {
    const double s = static_cast<double>(r - c) / static_cast<double>(n);
    const double u = static_cast<double>(c) / static_cast<double>(n);
    return t[0] + (t[1] - t[0]) * s + (t[2] - t[0]) * u;
  };
  const std::size_t c = at / 2;
  if (at % 2 == 0) return {point(row, c), point(row + 1, c), point(row + 1, c + 1)};
  return {point(row, c), point(row + 1, c + 1), point(row, c + 1)};
}

}  // namespace lode::simplification
