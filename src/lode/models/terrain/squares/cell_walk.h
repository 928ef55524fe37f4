#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "lode/delaunay/predicates.h"

namespace lode::squares {

/// Half of a cell, cut from its lower left to its upper right corner (x to the right, y up).
struct CellHalf {
  std::int32_t x = 0;  ///< The cell's lower left corner.
  std::int32_t y = 0;
  bool is_upper = false;  ///< The half with the upper left corner.

  friend bool operator==(const CellHalf&, const CellHalf&) = default;
};

/// Those that meet in a place or along a line.
class CellHalves {
 public:
  void add(const CellHalf& half) { halves_[n_++] = half; }
  [[nodiscard]] std::span<const CellHalf> get() const { return {halves_.data(), n_}; }

 private:
  std::array<CellHalf, 8> halves_{};
  std::size_t n_ = 0;
};

/// The cells of a raster, to be found by places as columns and rows.
struct CellGrid {
  std::int32_t n_columns = 0;  ///< Of cells.
  std::int32_t n_rows = 0;

  [[nodiscard]] bool has(std::int32_t x, std::int32_t y) const {
    return x >= 0 && y >= 0 && x < n_columns && y < n_rows;
  }
};

/// The halves that hold a finite place, with their sides; exactly. None beside the raster.
[[nodiscard]] CellHalves halves_at(const CellGrid& grid, const delaunay::Point& p);

/// What halves of cells have of a segment: one, or two where it runs along a side that both have;
/// none where it is beside the raster.
struct WalkStep {
  double begin = 0;  ///< Shares of the segment, begin < end.
  double end = 0;
  CellHalves halves;
};

/// Follows a segment from a to b, finite and different, through the cells of the raster. Steps are
/// in its order, and each begins where the one before ends, at sides of halves; what is before the
/// raster, or behind, is left out. Which cells follow each other is decided by whole numbers, so
/// that none is lost to rounding; two sides that are met within rounding may be met in either
/// order. O(columns and rows that are crossed).
void walk_cells(const CellGrid& grid, const delaunay::Point& a, const delaunay::Point& b,
                const std::function<void(const WalkStep&)>& visit);

}  // namespace lode::squares
