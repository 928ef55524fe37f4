#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"

namespace lode::hierarchy_file {

/// A part of an outline along a column or a row.
struct OutlinePart {
  bool is_column = false;
  std::int32_t line = 0;  ///< Which: x of a column, y of a row.
  std::int32_t low = 0;   ///< Along it.
  std::int32_t high = 0;
  bool rises = false;  ///< From low to high; what is inside is on the left.

  bool operator==(const OutlinePart&) const = default;
};

/// The part between two nodes. Fails where it is not along a column or row, which are `scale` nodes
/// apart.
[[nodiscard]] Result<OutlinePart> outline_part(delaunay::LatticePoint from,
                                               delaunay::LatticePoint to, std::int32_t scale);

/// Parts in order, with those joined that follow one another: so equal for equal outlines, however
/// these are cut. Fails where parts lie on one another, as the two sides of a crack do.
[[nodiscard]] Result<std::vector<OutlinePart>> join_outline(std::vector<OutlinePart> parts);

/// Whether the joint outline goes round no place twice, nor the other way. O(n log n).
[[nodiscard]] bool goes_round_once(const std::vector<OutlinePart>& outline);

}  // namespace lode::hierarchy_file
