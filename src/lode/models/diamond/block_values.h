#pragma once

// What the blocks of a file hold of a field: docs/format.md, section 7.

#include <algorithm>
#include <limits>
#include <type_traits>
#include <vector>

#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/row_codes.h"
#include "lode/models/diamond/sample_rows.h"

namespace lode::diamond {

namespace detail {

/// Samples of a region's points, in their order.
template <typename T, int D, typename Field>
std::vector<T> sample_values(const Field& field, const Region<D>& r) {
  std::vector<T> values(count_points(r));
  T* to = values.data();
  for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
    for (std::int32_t& x : q.v) x <<= r.level;
    to = copy_samples<T, D>(field, q, n, stride << r.level, to);
  });
  return values;
}

/// One attribute of the region's nodes; encode(first, n, stride, to) writes those of a row.
template <typename T, int D, typename Encode>
std::vector<T> attribute_values(const Index<D>& dims, const Region<D>& r, const Encode& encode) {
  std::vector<T> values(count_points(r));
  T* to = values.data();
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    encode(linear_index<D>(dims, q), as_size(n), as_size(stride), to);
    to += n;
  });
  return values;
}

template <typename T>
void copy_row(const T* __restrict from, std::size_t n, std::size_t stride, T* __restrict to) {
  if (stride == 1)
    std::copy_n(from, n, to);
  else
    for (std::size_t i = 0; i < n; ++i) to[i] = from[2 * i];
}

/// Of a row of ranges their ends as they are stored.
template <typename R>
void encode_range_ends(bool is_low, const float* low, const float* high, std::size_t n,
                       std::size_t stride, R* to) {
  if constexpr (std::is_integral_v<R>) {
    (is_low ? encode_lows<R> : encode_highs<R>)(low, high, n, stride, to);
  } else {
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t at = i * stride;
      const bool is_empty = low[at] > high[at];
      if (is_low)
        to[i] = is_empty ? std::numeric_limits<R>::max() : low[at];
      else
        to[i] = is_empty ? std::numeric_limits<R>::lowest() : high[at];
    }
  }
}

template <int D, typename Field, typename Visit>
void visit_attributes(const Field& field, const WorldErrors& worlds, const Region<D>& r,
                      const Visit& visit) {
  const NodeLevel& nodes = field.levels[as_size(r.level)];
  const Index<D> dims = field.shape.grid_dims(r.level);
  const auto as_it_is = [&]<typename T>(const T* values) {
    return attribute_values<T, D>(dims, r,
                                  [&](std::size_t first, std::size_t n, std::size_t stride, T* to) {
                                    copy_row(values + first, n, stride, to);
                                  });
  };
  visit(Kind::errors, as_it_is(nodes.error.data()));
  visit_range_type(field.storage, [&]<typename R>() {
    for (const Kind kind : {Kind::lows, Kind::highs})
      visit(kind, attribute_values<R, D>(
                      dims, r, [&](std::size_t first, std::size_t n, std::size_t stride, R* to) {
                        encode_range_ends(kind == Kind::lows, nodes.low.data() + first,
                                          nodes.high.data() + first, n, stride, to);
                      }));
  });
  visit(Kind::worlds, as_it_is(worlds[as_size(r.level)].data()));
}

}  // namespace detail

/// Calls visit(kind, values) for each block of a group, in the order of the file: a vector of what
/// it holds for the region's points. Nothing where there are none. `origin` is where the field's
/// lattice begins in the one that the group is a region of.
template <int D, typename Field, typename Visit>
void visit_block_values(const Field& field, const WorldErrors& worlds, const Index<D>& origin,
                        const BlockGroup<D>& group, const Visit& visit) {
  Region<D> r = group.region;
  if (count_points(r) == 0) return;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    r.lower[i] -= origin[i] >> r.level;
    r.upper[i] -= origin[i] >> r.level;
  }
  if (!group.is_samples) return detail::visit_attributes<D>(field, worlds, r, visit);
  visit_storage_type(field.storage, [&]<typename T>() {
    visit(Kind::samples, detail::sample_values<T, D>(field, r));
  });
}

}  // namespace lode::diamond
