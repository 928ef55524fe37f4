#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lode/locate/cell_locator.h"

namespace lode {

/// Whether the closed cell holds p, by exact signs: no point of a mesh is lost between its cells.
/// Flat cells hold nothing.
[[nodiscard]] bool holds(const CellLocator& locator, std::uint32_t cell, const Vec3d& p);

/// The cell that holds p: of several one of `preferred` (by cell, not 0; empty: none), then the one
/// with the largest smallest weight, then the first. None where p is outside.
[[nodiscard]] std::optional<std::uint32_t> find_cell(const CellLocator& locator, const Vec3d& p,
                                                     std::span<const std::uint8_t> preferred);

/// A linear function's value, and by how much rounding may have put it off.
struct RoundedValue {
  double value = 0;
  double low = 0;
  double high = 0;
};

/// The function that is linear on the cell, with these values at its corners, at a point of the
/// cell that is up to `distance` from p. Never beyond the corners' values: of cells too flat for
/// doubles the bounds are these.
[[nodiscard]] RoundedValue value_in(const CellLocator& locator, std::uint32_t cell, const Vec3d& p,
                                    const std::array<double, 4>& values, double distance = 0);

}  // namespace lode
