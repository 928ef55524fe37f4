#include "lode/api/quadtree_budget.h"

#include "lode/core/least_float.h"

namespace lode {
namespace {

template <typename Tree>
std::optional<double> least_tolerance(const Tree& tree, std::uint64_t max_leaves) {
  return least_float(
      [&](double tolerance) { return tree.count_leaves(tolerance, max_leaves) <= max_leaves; });
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
