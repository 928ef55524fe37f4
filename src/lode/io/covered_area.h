#pragma once

#include <vector>

namespace lode::io {

/// left <= right, top <= bottom.
struct Rectangle {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;
};

/// The area that rectangles cover together: a line sweeps over them, O(n log n) (Bentley,
/// Algorithms for Klee's rectangle problems, 1977).
[[nodiscard]] double covered_area(const std::vector<Rectangle>& rectangles);

}  // namespace lode::io
