#include "lode/models/diamond/selection.h"

namespace lode::diamond {

template <int D, typename Field>
Selection<D, Field>::Selection(const Field& model, double isovalue, double tolerance)
    : model_(model),
      isovalue_(isovalue),
      is_full_(tolerance == 0),
      tolerance_(tolerance_code(tolerance)) {
  const double reference = model.range_reference();
  relative_below_ = relative_above_ = isovalue - reference;
  if (reference != 0) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    relative_below_ = std::nextafter(relative_below_, -kInfinity);
    relative_above_ = std::nextafter(relative_above_, kInfinity);
  }
}

template <int D, typename Field>
std::size_t Selection<D, Field>::index_of(const Diamond<D>& d) const {
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

template class Selection<2>;
template class Selection<3>;
template class Selection<2, CoarseField<2>>;
template class Selection<3, CoarseField<3>>;

}  // namespace lode::diamond
