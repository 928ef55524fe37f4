#include "lode/models/diamond/relaxed_box.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "lode/models/diamond/sample_rows.h"

namespace lode::diamond {

void RelaxedBox::open(const Index<3>& dims, const LatticeBox<3>& box) {
  sides_.open(dims, box);
  size_ = box.upper - box.lower;
  values_.resize(n_points<3>(size_));
  marks_.resize(values_.size());
}

template <typename Field>
void RelaxedBox::fill_row(const Field& field, std::size_t row, std::int32_t step) {
  const auto n = as_size(size_[0]);
  const Index<3> first = (sides_.box().lower + point_of<3>(size_, row * n)) * step;
  visit_storage_type(field.storage, [&]<typename T>() {
    std::array<T, kBrickSamples<3> + 8> some;
    for (std::size_t x = 0; x < n; x += some.size()) {
      const std::size_t n_here = std::min(n - x, some.size());
      const Index<3> p = first + Index<3>{{static_cast<std::int32_t>(x) * step, 0, 0}};
      copy_samples(field, p, static_cast<std::int32_t>(n_here), step, some.data());
      set_row(std::span<const T>(some.data(), n_here), row * n + x);
      if (!field.has_holes()) continue;
      for (std::size_t i = 0; i < n_here; ++i)
        if (field.is_hole(static_cast<double>(some[i])))
          values_[row * n + x + i] = std::numeric_limits<float>::quiet_NaN();
    }
  });
}

/// Without branches, and with nothing that could be one of the arrays.
template <typename T>
void RelaxedBox::set_row(std::span<const T> samples, std::size_t at) {
  // So that two of them can be added.
  constexpr double kLargest = std::numeric_limits<float>::max() / 4;
  float* const values = values_.data() + at;
  std::uint8_t* const marks = marks_.data() + at;
  const double isovalue = isovalue_;
  const double least_inside = least_inside_;
  const double least_fixed_inside = least_fixed_inside_;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // However small a difference is, its sign is that of the larger value: but for 0, to be +0.
    const double above = static_cast<double>(samples[i]) - isovalue + 0.0;
    values[i] = static_cast<float>(std::min(std::max(above, -kLargest), kLargest));
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto value = static_cast<double>(samples[i]);
    const int inside = value >= least_inside ? kMayBeInside : 0;
    const int outside = value < least_fixed_inside ? kMayBeOutside : 0;
    marks[i] = static_cast<std::uint8_t>(inside | outside);
  }
}

template void RelaxedBox::fill_row(const Model<3>&, std::size_t, std::int32_t);
template void RelaxedBox::fill_row(const CoarseField<3>&, std::size_t, std::int32_t);
template void RelaxedBox::fill_row(const FlatField<3>&, std::size_t, std::int32_t);

}  // namespace lode::diamond
