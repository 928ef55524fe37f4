#pragma once

#include <algorithm>
#include <vector>

#include "lode/models/diamond/coarse_field.h"
#include "lode/models/diamond/flat_field.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Appends n samples, the first at lattice point p and `step` apart along x; where they lie beyond
/// the data, the nearest ones.
template <typename T, int D>
T* copy_samples(const Model<D>& model, const Index<D>& p, std::int32_t n, std::int32_t step,
                T* to) {
  Index<D> local = model.clamped(p);
  Index<D> brick;
  for (std::size_t a = 0; a < as_size(D); ++a) {
    brick[a] = std::min(local[a] / kBrickEdge<D>, model.brick_dims[a] - 1);
    local[a] -= brick[a] * kBrickEdge<D>;
  }
  local[0] = 0;
  const std::int32_t last = model.shape.dims[0] - 1;
  std::int32_t x = p[0];
  while (n > 0) {
    // What lies in one brick; beyond the data its last sample again and again.
    brick[0] = std::min(std::min(x, last) / kBrickEdge<D>, model.brick_dims[0] - 1);
    const std::int32_t begin = brick[0] * kBrickEdge<D>;
    const T* from =
        reinterpret_cast<const T*>(model.brick(linear_index<D>(model.brick_dims, brick))) +
        model.brick_offset(local);
    const std::int32_t end = std::min(begin + kBrickEdge<D>, last);
    const std::int32_t n_here = x <= end ? std::min(n, (end - x) / step + 1) : n;
    if (x > end)
      std::fill_n(to, n_here, from[last - begin]);
    else if (step == 1)
      std::copy_n(from + (x - begin), n_here, to);
    else
      for (std::int32_t i = 0; i < n_here; ++i) to[i] = from[x - begin + i * step];
    x += n_here * step;
    n -= n_here;
    to += n_here;
  }
  return to;
}

template <typename T, int D>
T* copy_samples(const CoarseField<D>& field, const Index<D>& p, std::int32_t n, std::int32_t step,
                T* to) {
  Index<D> at = p;
  for (std::int32_t i = 0; i < n; ++i, at[0] += step) *to++ = static_cast<T>(field.value(at));
  return to;
}

/// As of fields in memory; all of it lies in the data.
template <typename T>
T* copy_samples(const FlatField<3>& field, const Index<3>& p, std::int32_t n, std::int32_t step,
                T* to) {
  const T* from =
      reinterpret_cast<const T*>(field.samples.data()) + linear_index<3>(field.shape.dims, p);
  if (step == 1) return std::copy_n(from, n, to);
  for (std::int32_t i = 0; i < n; ++i, from += step) *to++ = *from;
  return to;
}

/// Calls see(i, value, is_hole) for each of them; all lie in the data.
template <typename Field, typename See>
void see_samples(const Field& field, const Index<3>& p, std::int32_t n, std::int32_t step,
                 const See& see) {
  const bool has_holes = field.has_holes();
  visit_storage_type(field.storage, [&]<typename T>() {
    std::vector<T> samples(as_size(n));
    copy_samples(field, p, n, step, samples.data());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto value = static_cast<double>(samples[i]);
      see(i, value, has_holes && field.is_hole(value));
    }
  });
}

}  // namespace lode::diamond
