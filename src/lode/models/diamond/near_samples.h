#pragma once

#include <limits>

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The samples round a lattice point, at most `reach` away along each axis. Where all of them are
/// samples of one brick, as most are, reading one costs no look at bricks or borders. T: the
/// model's storage.
template <int D, typename T, typename Field = Model<D>>
class NearSamples;

template <int D, typename T>
class NearSamples<D, T, Model<D>> {
 public:
  NearSamples(const Model<D>& model, const Index<D>& centre, std::int32_t reach)
      : model_(model), centre_(centre) {
    Index<D> brick;
    Index<D> local;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      brick[i] = centre[i] / kBrickEdge<D>;
      local[i] = centre[i] % kBrickEdge<D>;
      if (local[i] < reach || local[i] + reach > kBrickEdge<D> || centre[i] < reach ||
          centre[i] + reach >= model.shape.dims[i])
        return;
    }
    middle_ = reinterpret_cast<const T*>(model.brick(linear_index<D>(model.brick_dims, brick))) +
              Model<D>::brick_offset(local);
  }

  /// NaN for a hole; beyond the data that of the nearest sample.
  [[nodiscard]] double operator()(const Index<D>& p) const {
    if (middle_ == nullptr) return model_.value_or_nan(p);
    std::ptrdiff_t offset = 0;
    for (std::size_t i = as_size(D); i-- > 0;)
      offset = offset * kBrickSamples<D> + (p[i] - centre_[i]);
    const auto value = static_cast<double>(middle_[offset]);
    return model_.has_holes() && model_.is_hole(value) ? std::numeric_limits<double>::quiet_NaN()
                                                       : value;
  }

 private:
  const Model<D>& model_;
  Index<D> centre_;
  const T* middle_ = nullptr;  ///< Null: some may lie elsewhere.
};

}  // namespace lode::diamond
