#include "lode/models/diamond/selection.h"

#include <cmath>
#include <limits>

namespace lode::diamond {

RelativeIsovalue RelativeIsovalue::of(double isovalue, double reference) {
  const double relative = isovalue - reference;
  if (reference == 0) return {relative, relative};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {std::nextafter(relative, -kInfinity), std::nextafter(relative, kInfinity)};
}

template <int D, typename Field>
std::size_t ToleranceSelection<D, Field>::index_of(const Diamond<D>& d) const {
  const Shape<D>& shape = model_.shape;
  Index<D> q;
  if (d.level > 0) {
    for (std::size_t i = 0; i < as_size(D); ++i) q[i] = d.centre[i] >> d.level;
    return linear_index<D>(shape.grid_dims(d.level), q);
  }
  LODE_EXPECTS(d.tier == 0);
  Index<D> dims;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    q[i] = d.centre[i] >> 1;
    dims[i] = shape.n_cubes(0, static_cast<int>(i));
  }
  return linear_index<D>(dims, q);
}

template class ToleranceSelection<2>;
template class ToleranceSelection<3>;
template class ToleranceSelection<2, CoarseField<2>>;
template class ToleranceSelection<3, CoarseField<3>>;

}  // namespace lode::diamond
