#include "lode/models/terrain/right_triangle_bisection/nested_errors.h"

namespace lode::bisection {
namespace {

/// Of any node.
void join_children(const Lattice& lattice, LatticePoint node, float* errors) {
  const Diamond diamond(node);
  const std::int32_t reach = diamond.is_square ? diamond.reach : diamond.reach / 2;
  float& error = errors[lattice.index(node)];
  for (const LatticePoint child : diamond.children())
    if (lattice.has(child) && lattice.has_area(child, reach))
      error = std::max(error, errors[lattice.index(child)]);
}

/// Of one whose children are on samples, at these distances in the array.
inline void join_four(float* at, std::int64_t a, std::int64_t b) {
  *at = std::max({*at, at[-a], at[a], at[-b], at[b]});
}

}  // namespace

void nest_errors(const Lattice& lattice, Threads threads, float* errors) {
  const std::int64_t stride = lattice.stride();
  const LatticePoint last = lattice.last();
  const auto nest = [&](std::int32_t reach, NodeKind kind) {
    const bool is_square = kind == NodeKind::square;
    const std::int32_t away = is_square ? reach : reach / 2;
    const std::int64_t a = is_square ? away : away * (stride + 1);
    const std::int64_t b = is_square ? away * stride : away * (stride - 1);
    for_each_node(lattice, reach, kind, threads, [&](LatticePoint p) {
      const bool is_inside =
          p.x >= away && p.y >= away && p.x + away <= last.x && p.y + away <= last.y;
      if (is_inside)
        join_four(errors + p.y * stride + p.x, a, b);
      else
        join_children(lattice, p, errors);
    });
  };
  for (std::int32_t reach = 1; 2 * reach <= lattice.side(); reach *= 2) {
    if (reach > 1) nest(reach, NodeKind::side);
    nest(reach, NodeKind::square);
  }
}

}  // namespace lode::bisection
