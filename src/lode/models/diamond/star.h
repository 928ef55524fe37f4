#pragma once

#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// The unrefined simplices of a diamond, in steps of h from its centre. They depend only on the
/// direction of its axis, of which there are 3^D - 1.
template <int D>
struct Star {
  int tag = D;  ///< Of all its simplices: the dimension of the bisected face.
  std::vector<Simplex<D>> simplices;
};

/// The star of the diamond whose axis begins at centre + h·step.
template <int D>
[[nodiscard]] const Star<D>& star_of_axis(const Index<D>& step);

template <int D>
[[nodiscard]] const Star<D>& star_of(const Diamond<D>& d) {
  Index<D> step = axis_ends<D>(d)[0] - d.centre;
  for (std::size_t i = 0; i < as_size(D); ++i) step[i] >>= d.level;
  return star_of_axis<D>(step);
}

extern template const Star<2>& star_of_axis<2>(const Index<2>&);
extern template const Star<3>& star_of_axis<3>(const Index<3>&);

/// A simplex of a star at its place.
template <int D>
[[nodiscard]] Simplex<D> placed(const Simplex<D>& s, const Diamond<D>& d) {
  Simplex<D> result = s;
  for (Index<D>& v : result.v) v = d.centre + v * d.h();
  return result;
}

}  // namespace lode::diamond
