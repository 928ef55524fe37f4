#include "lode/models/diamond/relaxed_box.h"

#include <algorithm>
#include <limits>

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
  // So that two of them can be added.
  constexpr double kLargest = std::numeric_limits<float>::max() / 4;
  const auto n = as_size(size_[0]);
  const Index<3> first = sides_.box().lower + point_of<3>(size_, row * n);
  see_samples(field, first * step, size_[0], step, [&](std::size_t x, double value, bool is_hole) {
    // However small a difference is, its sign is that of the larger value: but for 0, to be +0.
    const double above = value - isovalue_ + 0.0;
    values_[row * n + x] = is_hole ? std::numeric_limits<float>::quiet_NaN()
                                   : static_cast<float>(std::clamp(above, -kLargest, kLargest));
    marks_[row * n + x] =
        static_cast<std::uint8_t>((value >= least_inside_ ? kMayBeInside : 0) |
                                  (value < least_fixed_inside_ ? kMayBeOutside : 0));
  });
}

template void RelaxedBox::fill_row(const Model<3>&, std::size_t, std::int32_t);
template void RelaxedBox::fill_row(const CoarseField<3>&, std::size_t, std::int32_t);
template void RelaxedBox::fill_row(const FlatField<3>&, std::size_t, std::int32_t);

}  // namespace lode::diamond
