#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "lode/api/tetra_cut_shape.h"
#include "lode/locate/cell_locator.h"

namespace lode {

/// What the overlay of cuts with the reference mesh says of the errors that cells state.
struct TetraOverlayErrors {
  std::uint64_t n_cells = 0;  ///< Not the reference's.
  std::uint64_t n_above_stated = 0;
  double largest = 0;  ///< |F - F'| at any point.
  double largest_stated = 0;
  std::string first;  ///< The first that is above.

  void append(const TetraOverlayErrors& later);
};

/// Finds |F - F'| everywhere: cuts each cell of the reference at the faces of each cell of a cut
/// that it may meet. What is no deeper in the latter than the boundary may move does not count: at
/// seams which the reference does not weld F is another on either side. No part of it is shared
/// with what finds errors when a hierarchy is built.
class TetraOverlay {
 public:
  /// Both must outlive it.
  TetraOverlay(const TetraVertices& vertices, const TetraCells& reference, Threads threads);

  /// Of the field whose values the vertices have, and of which the cells state something. What
  /// rounding does to F' is allowed for. The same for any number of threads.
  [[nodiscard]] TetraOverlayErrors measure(const TetraCells& cells, Threads threads) const;
  /// Of one cell: the largest |F - F'|, less what rounding may have added.
  [[nodiscard]] double largest_in(const tetra_mt::Tetrahedron& cell) const;

 private:
  [[nodiscard]] std::array<double, 4> heights_of(const tetra_mt::Tetrahedron& cell) const;

  const TetraVertices& vertices_;
  const TetraCells& reference_;
  CellLocator locator_;
};

}  // namespace lode
