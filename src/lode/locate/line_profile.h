#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/locate/cell_locator.h"

namespace lode {

/// A piece of a line from a (t = 0) to b (t = 1) that lies in one cell.
struct LinePiece {
  std::uint32_t cell = 0;
  double begin = 0;
  double end = 0;
  /// By how much each may be off, because of rounding.
  double begin_rounding = 0;
  double end_rounding = 0;
  /// Whether the line has been outside all cells just before.
  bool starts_part = false;
};

/// Where the line meets which cells, from a to b: pieces that follow each other, but where it is
/// outside. On which sides of faces a and b lie is decided exactly; where the line runs in faces or
/// edges one of their cells has it, of `preferred` ones if there are such (by cell, not 0; empty:
/// none). Parts no longer than rounding, such as a touched corner, are left out, and so are such
/// gaps. Expects a and b to be different.
[[nodiscard]] std::vector<LinePiece> line_profile(const CellLocator& locator, const Vec3d& a,
                                                  const Vec3d& b,
                                                  std::span<const std::uint8_t> preferred);

/// Whether some point of the line from a to b is in the box, or so near that rounding may say so.
[[nodiscard]] bool meets_line(const Box3d& box, const Vec3d& a, const Vec3d& b);

}  // namespace lode
