#pragma once

#include <limits>

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The samples round a point of a level's grid, at most `reach` grid steps away along each axis.
/// Where all of them are samples of one brick or page, as most are, reading one costs no look at
/// bricks or borders. T: the field's storage.
template <int D, typename T>
class NearSamples {
 public:
  template <typename Field>
  NearSamples(const Field& field, const Index<D>& centre, std::int32_t reach, int level = 0) {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (centre[i] < reach << level || centre[i] + (reach << level) >= field.shape.dims[i]) return;
    is_in_data_ = true;
    field.find_near(*this, centre, reach, level);
  }

  /// Whether all are samples of the data,
  [[nodiscard]] bool is_in_data() const { return is_in_data_; }
  /// and one brick or page has them.
  [[nodiscard]] bool is_in_one() const { return middle_ != nullptr; }
  /// Then that at centre + steps, which may be a hole.
  [[nodiscard]] T at(const Index<D>& steps) const {
    std::ptrdiff_t offset = 0;
    for (std::size_t i = 0; i < as_size(D); ++i) offset += steps[i] * strides_[i];
    return middle_[offset];
  }

  /// The neighbours along an axis, the lower one first.
  [[nodiscard]] std::array<T, 2> beside(std::size_t axis) const {
    return {middle_[-strides_[axis]], middle_[strides_[axis]]};
  }

  /// For fields: `middle` is the centre's, and so far apart are those of the level.
  void found(const T* middle, const std::array<std::ptrdiff_t, as_size(D)>& strides) {
    middle_ = middle;
    strides_ = strides;
  }

 private:
  std::array<std::ptrdiff_t, as_size(D)> strides_{};
  const T* middle_ = nullptr;
  bool is_in_data_ = false;
};

/// The value at p, which is centre + steps: NaN for a hole; beyond the data that of the nearest
/// sample.
template <int D, typename T, typename Field>
[[nodiscard]] double near_value(const NearSamples<D, T>& near, const Field& field,
                                const Index<D>& p, const Index<D>& steps) {
  if (!near.is_in_one()) return field.value_or_nan(p);
  const auto value = static_cast<double>(near.at(steps));
  return field.has_holes() && field.is_hole(value) ? std::numeric_limits<double>::quiet_NaN()
                                                   : value;
}

}  // namespace lode::diamond
