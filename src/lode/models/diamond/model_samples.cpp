#include "lode/models/diamond/model_samples.h"

#include <limits>

namespace lode::diamond {

template <int D>
double ModelSamples<D>::sample(const Index3& index) const {
  Index<D> p;
  for (std::size_t i = 0; i < as_size(D); ++i) p[i] = index[as_size(model_.axes.axis[i])];
  const double value = model_.value(p);
  return model_.is_hole(value) ? std::numeric_limits<double>::quiet_NaN() : value;
}

template class ModelSamples<2>;
template class ModelSamples<3>;

}  // namespace lode::diamond
