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

template <int D>
void ModelSamples<D>::find_corners(const Index3& even, const Index3& step,
                                   std::array<double, 8>& values) const {
  if constexpr (D == 3) {
    model_.find_corners(even, step, values);
    if (!model_.has_holes()) return;
    for (double& value : values)
      if (model_.is_hole(value)) value = std::numeric_limits<double>::quiet_NaN();
  } else {
    FieldSamples::find_corners(even, step, values);
  }
}

template class ModelSamples<2>;
template class ModelSamples<3>;

}  // namespace lode::diamond
