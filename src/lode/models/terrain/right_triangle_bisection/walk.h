#pragma once

#include <array>
#include <cstdint>

#include "lode/models/terrain/right_triangle_bisection/bisection.h"

namespace lode::bisection {

/// A triangle of the hierarchy: corners turn left; the hypotenuse goes from a to b.
struct LatticeTriangle {
  LatticePoint a, b, c;

  [[nodiscard]] LatticePoint middle() const { return {(a.x + b.x) / 2, (a.y + b.y) / 2}; }
  [[nodiscard]] LatticeTriangle left() const { return {c, a, middle()}; }
  [[nodiscard]] LatticeTriangle right() const { return {b, c, middle()}; }
};

/// The two that cover the lattice.
[[nodiscard]] inline std::array<LatticeTriangle, 2> roots(const Lattice& lattice) {
  const std::int32_t n = lattice.side();
  return {{{{n, n}, {0, 0}, {n, 0}}, {{0, 0}, {n, n}, {0, n}}}};
}

/// Goes through the triangles of a mesh, from left to right in the two binary trees that bisection
/// makes. is_refined(i) says whether the node of index i of the lattice is, nodes that it waits for
/// being so, too; visit(a, b, c, i) gets the corners as indices of samples, and of the node that
/// was not refined, or kNoNode; pass(i) the indices of the samples that refined nodes stand on,
/// once or twice each.
template <typename IsRefined, typename Visit, typename Pass>
class Walk {
 public:
  static constexpr std::int64_t kNoNode = -1;

  Walk(const Lattice& lattice, const IsRefined& is_refined, const Visit& visit, const Pass& pass)
      : lattice_(lattice), is_refined_(is_refined), visit_(visit), pass_(pass) {}

  void all() const {
    for (const LatticeTriangle& root : roots(lattice_)) under(root, 2 * (lattice_.n_levels() - 1));
  }
  /// The part of the mesh under a triangle that can be bisected `depth` times.
  void under(const LatticeTriangle& t, int depth) const {
    const LatticePoint last = lattice_.last();
    const std::int32_t right = std::max({t.a.x, t.b.x, t.c.x});
    const std::int32_t top = std::max({t.a.y, t.b.y, t.c.y});
    if (std::min({t.a.x, t.b.x, t.c.x}) >= last.x || std::min({t.a.y, t.b.y, t.c.y}) >= last.y)
      return;
    if (right <= last.x && top <= last.y) {
      const std::int64_t a = index(t.a), b = index(t.b);
      const std::int64_t middle = depth > 0 ? (a + b) / 2 : kNoNode;
      if (depth > 0 && is_refined_(middle))
        within(a, b, index(t.c), middle, depth);
      else
        visit_(a, b, index(t.c), middle);
      return;
    }
    const std::int64_t middle = index(t.middle());
    if (depth > 0 && is_refined_(middle)) {
      pass_(index(lattice_.place(t.middle())));
      under(t.left(), depth - 1);
      under(t.right(), depth - 1);
    } else {
      visit_(index(lattice_.place(t.a)), index(lattice_.place(t.b)), index(lattice_.place(t.c)),
             depth > 0 ? middle : kNoNode);
    }
  }

 private:
  [[nodiscard]] std::int64_t index(LatticePoint node) const {
    return static_cast<std::int64_t>(lattice_.index(node));
  }
  /// Of corners that are samples, whose node is refined.
  void within(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t middle,
              int depth) const {
    pass_(middle);
    if (depth == 1) {
      visit_(c, a, middle, kNoNode);
      visit_(b, c, middle, kNoNode);
      return;
    }
    const std::int64_t left = (c + a) / 2;
    if (is_refined_(left))
      within(c, a, middle, left, depth - 1);
    else
      visit_(c, a, middle, left);
    const std::int64_t right = (b + c) / 2;
    if (is_refined_(right))
      within(b, c, middle, right, depth - 1);
    else
      visit_(b, c, middle, right);
  }

  const Lattice& lattice_;
  const IsRefined& is_refined_;
  const Visit& visit_;
  const Pass& pass_;
};

}  // namespace lode::bisection
