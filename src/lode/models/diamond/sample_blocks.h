#pragma once

// Blocks of samples that may reach beyond the data.

#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "lode/models/diamond/block_layout.h"
#include "lode/store/reader.h"

namespace lode::diamond {

/// Puts the samples of a region's block that lie in the data into `all`, which has those of the
/// data, x fastest, and gives back the others, in the block's order.
template <typename T, int D>
[[nodiscard]] std::vector<std::byte> put_samples_of(const Shape<D>& shape, const Region<D>& r,
                                                    const std::byte* from, std::byte* all) {
  std::vector<std::byte> beyond;
  for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
    const std::int32_t n_inside = count_inside(shape, r.level, q, n, stride);
    for (std::int32_t& x : q.v) x <<= r.level;
    std::byte* to = n_inside > 0 ? all + linear_index<D>(shape.dims, q) * sizeof(T) : nullptr;
    const std::size_t step = sizeof(T) * as_size(stride << r.level);
    for (std::size_t i = 0; i < as_size(n_inside); ++i, from += sizeof(T))
      std::memcpy(to + i * step, from, sizeof(T));
    const std::byte* end = from + as_size(n - n_inside) * sizeof(T);
    beyond.insert(beyond.end(), from, end);
    from = end;
  });
  return beyond;
}

/// Calls body(grid point, place of the nearest sample among those of the data) for the points of a
/// region beyond the data, in the block's order.
template <int D, typename F>
void for_each_beyond(const Shape<D>& shape, const Region<D>& r, const F& body) {
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    for (std::int32_t i = count_inside(shape, r.level, q, n, stride); i < n; ++i) {
      Index<D> at = q;
      at[0] += i * stride;
      Index<D> nearest;
      for (std::size_t a = 0; a < as_size(D); ++a)
        nearest[a] = std::min(at[a] << r.level, shape.dims[a] - 1);
      body(at, linear_index<D>(shape.dims, nearest));
    }
  });
}

/// Compares the samples beyond the data that one block holds with the nearest ones in `all`, bit by
/// bit, as a hole may be NaN.
template <typename T, int D>
[[nodiscard]] Result<void> check_beyond(const store::Reader& reader, const Shape<D>& shape,
                                        const Region<D>& r, const std::byte* all,
                                        std::span<const std::byte> beyond) {
  if (beyond.empty()) return {};
  const std::byte* from = beyond.data();
  Error error;
  for_each_beyond<D>(shape, r, [&](const Index<D>& at, std::size_t nearest) {
    const std::byte* inside = all + nearest * sizeof(T);
    const std::byte* here = std::exchange(from, from + sizeof(T));
    if (std::equal(here, here + sizeof(T), inside) || !error.message.empty()) return;
    T expected;
    T got;
    std::memcpy(&expected, inside, sizeof(T));
    std::memcpy(&got, here, sizeof(T));
    error = fail(
        "{}: {}: beyond the data at grid point {}: expected the nearest sample, {}, got {}",
        reader.path(), describe(key_of(Kind::samples, r)), fmt::join(at.v, " "), expected, got);
  });
  if (!error.message.empty()) return error;
  return {};
}

}  // namespace lode::diamond
