#pragma once

// The implicit diamond hierarchy of a regular lattice, in any dimension: everything about a node
// follows from the integer coordinates of its centre.
// Sources: Borgo, Scopigno, Cignoni, Pascucci, "A Progressive Subdivision Paradigm" (2003);
// Maubach, "Local bisection refinement for n-simplicial grids" (1995).

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "lode/core/expects.h"
#include "lode/core/inline_list.h"
#include "lode/core/vec.h"

namespace lode::diamond {

template <int D>
using Index = Vec<std::int32_t, static_cast<std::size_t>(D)>;

inline constexpr std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

[[nodiscard]] constexpr std::size_t power(std::size_t base, int exponent) {
  return exponent == 0 ? 1 : base * power(base, exponent - 1);
}

/// Some lattice points near one: at most its neighbours.
template <int D>
using NearPoints = InlineList<Index<D>, power(3, D) - 1>;

template <int D>
[[nodiscard]] constexpr Index<D> all_equal(std::int32_t n) {
  Index<D> p;
  for (std::size_t i = 0; i < as_size(D); ++i) p[i] = n;
  return p;
}

/// The steps to a corner of a unit cube: bit i of `corner` is that along axis i.
template <int D>
[[nodiscard]] constexpr Index<D> corner_steps(unsigned corner) {
  Index<D> steps;
  for (int i = 0; i < D; ++i) steps[as_size(i)] = static_cast<std::int32_t>((corner >> i) & 1U);
  return steps;
}

/// The largest power of two, as an exponent, that divides all coordinates; 31 for the origin.
template <int D>
[[nodiscard]] constexpr int common_exponent(const Index<D>& p) {
  std::uint32_t bits = 0;
  for (int i = 0; i < D; ++i) bits |= static_cast<std::uint32_t>(p[as_size(i)]);
  return bits == 0 ? 31 : std::countr_zero(bits);
}

/// A node: the bisection at one lattice point. With h = 2^level, the coordinates that are odd
/// multiples of h are the axis directions; tier = D - how many there are. Its domain lies in
/// centre ± h.
template <int D>
struct Diamond {
  Index<D> centre;
  int level = 0;          ///< h = 2^level.
  int tier = 0;           ///< 0 .. D-1; tier 0 is a cube of side 2h.
  std::uint32_t odd = 0;  ///< Bit i: coordinate i is an odd multiple of h.

  friend constexpr bool operator==(const Diamond&, const Diamond&) = default;

  [[nodiscard]] constexpr std::int32_t h() const { return std::int32_t{1} << level; }
  [[nodiscard]] constexpr bool is_odd(int axis) const { return ((odd >> axis) & 1U) != 0; }
};

/// The diamond centred at `centre`, which must not be a corner of the root cube.
template <int D>
[[nodiscard]] constexpr Diamond<D> diamond_at(const Index<D>& centre) {
  Diamond<D> d{centre, common_exponent<D>(centre), 0, 0};
  int n_odd = 0;
  for (int i = 0; i < D; ++i)
    if (((centre[as_size(i)] >> d.level) & 1) != 0) {
      d.odd |= 1U << i;
      ++n_odd;
    }
  d.tier = D - n_odd;
  return d;
}

/// The two ends of the bisected edge: along exactly the odd coordinates, centre ± h; the first
/// has those coordinates ≡ 0 mod 4h, the second ≡ 2h.
template <int D>
[[nodiscard]] constexpr std::array<Index<D>, 2> axis_ends(const Diamond<D>& d) {
  std::array<Index<D>, 2> ends{d.centre, d.centre};
  const std::int32_t h = d.h();
  for (int i = 0; i < D; ++i) {
    if (!d.is_odd(i)) continue;
    const std::int32_t c = d.centre[as_size(i)];
    const std::int32_t step = ((c >> d.level) & 3) == 1 ? -h : h;
    ends[0][as_size(i)] = c + step;
    ends[1][as_size(i)] = c - step;
  }
  return ends;
}

/// The nodes whose diamonds receive the simplices that bisecting `d` makes: 2·(odd) in the same
/// level, or the 2^D cubes of the next finer one. Empty at the finest (level 0, tier D-1). Not
/// clipped to any root cube.
template <int D>
[[nodiscard]] NearPoints<D> children(const Diamond<D>& d) {
  NearPoints<D> result;
  if (d.tier < D - 1) {
    for (int i = 0; i < D; ++i)
      if (d.is_odd(i))
        for (const std::int32_t s : {-d.h(), d.h()}) {
          Index<D> c = d.centre;
          c[as_size(i)] += s;
          result.push_back(c);
        }
    return result;
  }
  if (d.level == 0) return result;
  for (int corner = 0; corner < (1 << D); ++corner) {
    Index<D> c = d.centre;
    for (int i = 0; i < D; ++i) c[as_size(i)] += ((corner >> i) & 1) != 0 ? d.h() / 2 : -d.h() / 2;
    result.push_back(c);
  }
  return result;
}

/// The nodes that must be refined before `d`: 2·tier in the same level, by axis, the lower side
/// first; or D of the next coarser one, by axis. Empty for the root. Not clipped to any root cube
/// of side `root`, except that a tier-0 node of that size has no parents.
template <int D>
[[nodiscard]] constexpr NearPoints<D> parents(const Diamond<D>& d, std::int32_t root) {
  NearPoints<D> result;
  const std::int32_t h = d.h();
  if (d.tier > 0) {
    for (int i = 0; i < D; ++i)
      if (!d.is_odd(i))
        for (const std::int32_t s : {-h, h}) {
          Index<D> c = d.centre;
          c[as_size(i)] += s;
          result.push_back(c);
        }
    return result;
  }
  if (2 * h >= root) return result;
  // A cube's even corner has all coordinates ≡ 0 mod 4h; each parent one ≡ 2h.
  const Index<D> even = axis_ends<D>(d)[0];
  for (std::size_t i = 0; i < as_size(D); ++i) {
    Index<D> c = even;
    c[i] = 2 * d.centre[i] - c[i];
    result.push_back(c);
  }
  return result;
}

/// domain_vertices() of a diamond with these odd axes, in units of h from its centre.
template <int D>
[[nodiscard]] NearPoints<D> domain_vertex_steps(std::uint32_t odd) {
  NearPoints<D> result;
  for (std::size_t code = 0; code < power(3, D); ++code) {
    Index<D> step;
    std::uint32_t moved = 0;
    std::size_t rest = code;
    for (int i = 0; i < D; ++i, rest /= 3) {
      step[as_size(i)] = static_cast<std::int32_t>(rest % 3) - 1;
      if (step[as_size(i)] != 0) moved |= 1U << i;
    }
    const bool is_face_corner = moved == odd;
    const bool is_larger_centre = moved != 0 && (moved & odd) == 0;
    if (is_face_corner || is_larger_centre) result.push_back(step);
  }
  return result;
}

/// The vertices of the diamond's simplices other than its centre: the corners of its face of
/// dimension D - tier, and the centres of the larger faces and cubes round that.
template <int D>
[[nodiscard]] NearPoints<D> domain_vertices(const Diamond<D>& d) {
  static const auto kSteps = [] {
    std::array<NearPoints<D>, power(2, D)> by_odd;
    for (std::uint32_t odd = 1; odd < by_odd.size(); ++odd)
      by_odd[odd] = domain_vertex_steps<D>(odd);
    return by_odd;
  }();
  NearPoints<D> result;
  for (const Index<D>& step : kSteps[d.odd]) result.push_back(d.centre + step * d.h());
  return result;
}

/// A simplex of the hierarchy in Maubach's form: the edge v[0] – v[tag] is bisected next;
/// v[0..tag] is a Kuhn chain of a face of dimension tag, the rest are centres of larger faces.
template <int D>
struct Simplex {
  std::array<Index<D>, as_size(D) + 1> v;
  int tag = D;

  [[nodiscard]] constexpr Index<D> bisection_point() const {
    Index<D> c;
    for (std::size_t i = 0; i < as_size(D); ++i) c[i] = (v[0][i] + v[as_size(tag)][i]) / 2;
    return c;
  }
};

/// Whether it is one of a unit cube's Kuhn simplices: its next bisection would leave the lattice.
template <int D>
[[nodiscard]] constexpr bool is_finest(const Simplex<D>& s) {
  return common_exponent<D>(s.v[0] - s.v[as_size(s.tag)]) == 0;
}

/// A box of lattice points.
template <int D>
struct LatticeBox {
  Index<D> lower, upper;

  [[nodiscard]] constexpr std::int32_t edge(int axis) const {
    return upper[as_size(axis)] - lower[as_size(axis)];
  }
};

template <int D>
[[nodiscard]] constexpr LatticeBox<D> bounds_of(const Simplex<D>& s) {
  LatticeBox<D> box{s.v[0], s.v[0]};
  for (const Index<D>& v : s.v)
    for (std::size_t i = 0; i < as_size(D); ++i) {
      box.lower[i] = std::min(box.lower[i], v[i]);
      box.upper[i] = std::max(box.upper[i], v[i]);
    }
  return box;
}

/// centre ± h, which contains the domain.
template <int D>
[[nodiscard]] constexpr LatticeBox<D> bounds_of(const Diamond<D>& d) {
  LatticeBox<D> box{d.centre, d.centre};
  for (std::size_t i = 0; i < as_size(D); ++i) {
    box.lower[i] -= d.h();
    box.upper[i] += d.h();
  }
  return box;
}

/// The two halves of a simplex, bisected at its bisection_point().
template <int D>
[[nodiscard]] constexpr std::array<Simplex<D>, 2> bisect(const Simplex<D>& s) {
  const Index<D> c = s.bisection_point();
  std::array<Simplex<D>, 2> halves{s, s};
  const std::size_t tag = as_size(s.tag);
  halves[0].v[tag] = c;
  for (std::size_t i = 0; i < tag; ++i) halves[1].v[i] = s.v[i + 1];
  halves[1].v[tag] = c;
  halves[0].tag = halves[1].tag = s.tag > 1 ? s.tag - 1 : D;
  return halves;
}

/// The D! Kuhn simplices of a cube of side `side`, from the corner with all coordinates
/// ≡ 0 mod 2·side to the opposite one. `lower` is the cube's lowest corner.
template <int D>
[[nodiscard]] std::vector<Simplex<D>> kuhn_simplices(const Index<D>& lower, std::int32_t side) {
  std::array<int, as_size(D)> order;
  for (int i = 0; i < D; ++i) order[as_size(i)] = i;
  Index<D> even;
  for (std::size_t i = 0; i < as_size(D); ++i)
    even[i] = ((lower[i] / side) & 1) == 0 ? lower[i] : lower[i] + side;
  std::vector<Simplex<D>> result;
  do {
    Simplex<D> s;
    s.v[0] = even;
    for (std::size_t j = 0; j < as_size(D); ++j) {
      s.v[j + 1] = s.v[j];
      const std::size_t axis = as_size(order[j]);
      s.v[j + 1][axis] += even[axis] == lower[axis] ? side : -side;
    }
    result.push_back(s);
  } while (std::next_permutation(order.begin(), order.end()));
  return result;
}

/// The shape of a data set's hierarchy: a root cube of side 2^n_levels round samples
/// 0 .. dims-1; only cubes that overlap the data exist at each level.
template <int D>
struct Shape {
  Index<D> dims;     ///< Samples per axis.
  int n_levels = 1;  ///< Levels 0 .. n_levels-1; the root diamond is tier 0 of the last.

  [[nodiscard]] static Shape of(const Index<D>& dims) {
    Shape shape{dims, 1};
    for (int i = 0; i < D; ++i)
      while ((std::int64_t{1} << shape.n_levels) < dims[as_size(i)] - 1) ++shape.n_levels;
    return shape;
  }
  [[nodiscard]] std::int32_t root_side() const { return std::int32_t{1} << n_levels; }
  /// Cubes of side 2^(level+1) along an axis; 0 when the axis has one sample.
  [[nodiscard]] std::int32_t n_cubes(int level, int axis) const {
    const std::int32_t side = std::int32_t{2} << level;
    return (dims[as_size(axis)] - 1 + side - 1) / side;
  }
  /// How a level's attributes are laid out: on its grid, level 0 as one per cube of side 2.
  [[nodiscard]] Index<D> attribute_dims(int level) const {
    if (level > 0) return grid_dims(level);
    Index<D> cubes;
    for (int i = 0; i < D; ++i) cubes[as_size(i)] = n_cubes(0, i);
    return cubes;
  }
  /// Points of the level's grid: multiples of 2^level in all cubes that overlap the data.
  [[nodiscard]] Index<D> grid_dims(int level) const {
    Index<D> g;
    for (int i = 0; i < D; ++i) g[as_size(i)] = 2 * n_cubes(level, i) + 1;
    return g;
  }
  [[nodiscard]] bool has_cells() const {
    return std::all_of(dims.v.begin(), dims.v.end(), [](std::int32_t n) { return n > 1; });
  }
  [[nodiscard]] bool is_sample(const Index<D>& p) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (p[i] < 0 || p[i] >= dims[i]) return false;
    return true;
  }
  /// Whether the inside of a box meets the data's box.
  [[nodiscard]] bool overlaps_data(const LatticeBox<D>& box) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (box.lower[i] >= dims[i] - 1 || box.upper[i] <= 0) return false;
    return true;
  }
  /// Whether simplices of a node or of one below it may reach across the last sample of an axis: it
  /// lies inside their cubes, and closer to the node's centre than they do. Nested: where a node's
  /// do, so do its parents'.
  [[nodiscard]] bool reaches_across(const Index<D>& centre, int level) const {
    const std::int32_t h = std::int32_t{1} << level;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t last = dims[i] - 1;
      const std::int32_t reach = ((centre[i] >> level) & 1) != 0 ? 3 * h : 2 * h;
      if (last % (2 * h) != 0 && std::abs(centre[i] - last) < reach) return true;
    }
    return false;
  }
};

/// The linear index of grid point q (in units of the grid's step), x fastest.
template <int D>
[[nodiscard]] constexpr std::size_t linear_index(const Index<D>& dims, const Index<D>& q) {
  std::size_t index = 0;
  for (int i = D - 1; i >= 0; --i)
    index = index * as_size(dims[as_size(i)]) + as_size(q[as_size(i)]);
  return index;
}

template <int D>
[[nodiscard]] constexpr std::size_t n_points(const Index<D>& dims) {
  std::size_t n = 1;
  for (int i = 0; i < D; ++i) n *= as_size(dims[as_size(i)]);
  return n;
}

/// The inverse of linear_index.
template <int D>
[[nodiscard]] constexpr Index<D> point_of(const Index<D>& dims, std::size_t index) {
  Index<D> q;
  for (int i = 0; i < D; ++i) {
    q[as_size(i)] = static_cast<std::int32_t>(index % as_size(dims[as_size(i)]));
    index /= as_size(dims[as_size(i)]);
  }
  return q;
}

}  // namespace lode::diamond
