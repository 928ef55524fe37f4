#pragma once

#include <cstdint>

#include "lode/core/surface.h"

namespace lode {

/// How two surfaces differ, cell by cell (triangle by triangle, or line by line).
struct MatchReport {
  std::uint64_t n_cells = 0;      ///< Of the surface looked at.
  std::uint64_t n_missing = 0;    ///< Cells of the expected surface that it lacks.
  std::uint64_t n_extra = 0;      ///< Cells that the expected surface does not have.
  std::uint64_t n_turned = 0;     ///< Cells that have it the other way round.
  std::uint32_t first_extra = 0;  ///< The lowest of those of the surface looked at,
  std::uint32_t first_turned = 0;
  std::uint32_t first_missing = 0;  ///< and of the expected one.

  [[nodiscard]] bool is_same() const { return n_missing + n_extra + n_turned == 0; }
};

/// Compares a well-formed surface with the one expected, in whatever order its cells and vertices
/// are: cells are the same whose corners lie within `distance` along each axis (world units), one
/// by one. `distance` > 0, and well below the cells' size.
[[nodiscard]] MatchReport match_surfaces(const Surface& expected, const Surface& surface,
                                         double distance);

}  // namespace lode
