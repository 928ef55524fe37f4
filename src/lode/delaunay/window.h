#pragma once

#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// The rectangle that a zoom window is: columns and rows, with its border.
struct Window {
  LatticePoint lower;
  LatticePoint upper;
};

/// Whether a closed triangle, which turns left, meets a window: exactly, as convex sets that do not
/// are separated by a side of one of them.
[[nodiscard]] bool meets_window(const LatticeCorners& triangle, const Window& window);

}  // namespace lode::delaunay
