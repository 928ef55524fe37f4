#include "lode/api/quadtree_budget.h"

#include <bit>
#include <limits>

namespace lode {
namespace {

template <typename Tree>
std::optional<double> least_tolerance(const Tree& tree, std::uint64_t max_leaves) {
  // Floats that are >= 0 are in the order of their bits.
  std::uint32_t low = 0;
  std::uint32_t high = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::max());
  const auto fits = [&](std::uint32_t bits) {
    return tree.leaves(static_cast<double>(std::bit_cast<float>(bits))).size() <= max_leaves;
  };
  if (!fits(high)) return {};
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (fits(middle))
      high = middle;
    else
      low = middle + 1;
  }
  return static_cast<double>(std::bit_cast<float>(high));
}

}  // namespace

std::optional<double> tolerance_of_cells(const surface_quadtree::SurfaceQuadtree& tree,
                                         std::uint64_t max_cells) {
  return least_tolerance(tree, max_cells / 2);
}

std::optional<double> tolerance_of_cells(
    const quaternary_triangulation::QuaternaryTriangulation& tree, std::uint64_t max_cells) {
  return least_tolerance(tree, max_cells);
}

}  // namespace lode
