#include "lode/models/diamond/cell_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace lode::diamond {

void FieldSamples::find_corners(const Index3& even, const Index3& step,
                                std::array<double, 8>& values) const {
  for (std::size_t corner = 0; corner < 8; ++corner) {
    Index3 p = even;
    for (std::size_t i = 0; i < 3; ++i)
      if (((corner >> i) & 1U) != 0) p[i] += step[i];
    values[corner] = sample(p);
  }
}

double VolumeSamples::sample(const Index3& index) const {
  const Index3& dims = volume_.info.grid.dims;
  const std::int64_t offset =
      index[0] + std::int64_t{dims[0]} * (index[1] + std::int64_t{dims[1]} * index[2]);
  const double value = visit_scalar_type(volume_.info.type, [&]<typename T>() {
    T typed;
    std::memcpy(&typed, volume_.samples.data() + static_cast<std::size_t>(offset) * sizeof(T),
                sizeof(T));
    return static_cast<double>(typed);
  });
  if (volume_.info.nodata && value == *volume_.info.nodata)
    return std::numeric_limits<double>::quiet_NaN();
  return value;
}

CellField::CellField(const FieldSamples& samples, const Index3& cell, double isovalue)
    : cell_(cell), isovalue_(isovalue), is_removed_(false) {
  for (std::size_t i = 0; i < 3; ++i) {
    const bool is_even = cell[i] % 2 == 0;
    even_[i] = is_even ? cell[i] : cell[i] + 1;
    step_[i] = samples.grid().dims[i] == 1 ? 0 : (is_even ? 1 : -1);
  }
  samples.find_corners(even_, step_, values_);
  for (double& value : values_) {
    value -= isovalue;
    is_removed_ |= !std::isfinite(value);
    magnitude_ = std::max(magnitude_, std::abs(value));
  }
}

Vec3d CellField::to_local(const Vec3d& index) const {
  Vec3d local;
  for (std::size_t i = 0; i < 3; ++i)
    local[i] = std::clamp(
        (index[i] - static_cast<double>(even_[i])) * static_cast<double>(step_[i]), 0.0, 1.0);
  return local;
}

Vec3d CellField::to_index(const Vec3d& local) const {
  Vec3d index;
  for (std::size_t i = 0; i < 3; ++i)
    index[i] = static_cast<double>(even_[i]) + local[i] * static_cast<double>(step_[i]);
  return index;
}

double CellField::value_at(const Vec3d& local) const {
  std::array<std::size_t, 3> axes = {0, 1, 2};
  if (local[axes[0]] < local[axes[1]]) std::swap(axes[0], axes[1]);
  if (local[axes[1]] < local[axes[2]]) std::swap(axes[1], axes[2]);
  if (local[axes[0]] < local[axes[1]]) std::swap(axes[0], axes[1]);
  // From the even corner one axis after the other, the largest coordinate first; the weights are
  // barycentric.
  const std::size_t one = std::size_t{1} << axes[0];
  const std::size_t two = one | (std::size_t{1} << axes[1]);
  return values_[0] * (1.0 - local[axes[0]]) + values_[one] * (local[axes[0]] - local[axes[1]]) +
         values_[two] * (local[axes[1]] - local[axes[2]]) + values_[7] * local[axes[2]];
}

bool is_cell(const Index3& dims, const Index3& cell) {
  for (std::size_t i = 0; i < 3; ++i)
    if (cell[i] < 0 || cell[i] > std::max(dims[i] - 2, 0)) return false;
  return true;
}

bool is_removed_cell(const FieldSamples& samples, const Index3& cell) {
  return CellField(samples, cell, 0.0).is_removed();
}

}  // namespace lode::diamond
