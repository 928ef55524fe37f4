#pragma once

// How a model is cut into the blocks of a .lode file; docs/format.md, section 7.

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "lode/models/diamond/model.h"
#include "lode/store/format.h"

namespace lode::diamond {

/// What a block holds, beside store::kIndexKind; part of the format.
enum class Kind : std::uint32_t { samples = 1, errors = 2, lows = 3, highs = 4, worlds = 5 };
/// Whether a block holds something of that: others a reader may ignore.
[[nodiscard]] inline bool is_of_model(const store::BlockKey& key) {
  return key.kind >= static_cast<std::uint32_t>(Kind::samples) &&
         key.kind <= static_cast<std::uint32_t>(Kind::worlds);
}

/// Grid points per edge of a block.
template <int D>
inline constexpr std::int32_t kBlockEdge = D == 3 ? 64 : 512;

/// One block's region of a level's grid: points lower <= q < upper, in steps of the level, without
/// those that belong to a coarser level (all coordinates even), except on the coarsest.
template <int D>
struct Region {
  int level = 0;
  Index<D> position, lower, upper;
  bool has_coarser_points = false;
};

template <int D>
std::uint64_t morton(const Index<D>& p) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 20; ++bit)
    for (int i = 0; i < D; ++i)
      code |= static_cast<std::uint64_t>((p[as_size(i)] >> bit) & 1) << (bit * D + i);
  return code;
}

/// Blocks along an axis with n grid points. Grids have 2^k + 1 points or so: the last block also
/// holds the plane that would otherwise be alone, and has up to kBlockEdge + 1 points an edge.
template <int D>
constexpr std::int32_t n_blocks(std::int32_t n) {
  return std::max(1, (n + kBlockEdge<D> - 2) / kBlockEdge<D>);
}

template <int D>
Index<D> block_counts(const Index<D>& dims) {
  Index<D> n;
  for (std::size_t i = 0; i < as_size(D); ++i) n[i] = n_blocks<D>(dims[i]);
  return n;
}

/// The region of the block at a position, of a grid of so many points.
template <int D>
Region<D> region_at(const Index<D>& dims, int level, const Index<D>& position,
                    bool has_coarser_points) {
  Region<D> r{level, position, {}, {}, has_coarser_points};
  for (std::size_t a = 0; a < as_size(D); ++a) {
    r.lower[a] = position[a] * kBlockEdge<D>;
    r.upper[a] = position[a] == n_blocks<D>(dims[a]) - 1 ? dims[a] : r.lower[a] + kBlockEdge<D>;
  }
  return r;
}

template <int D>
std::vector<Region<D>> regions_of(const Index<D>& dims, int level, bool has_coarser_points) {
  const Index<D> n = block_counts<D>(dims);
  std::vector<Region<D>> regions;
  for (std::size_t i = 0; i < n_points<D>(n); ++i)
    regions.push_back(region_at<D>(dims, level, point_of<D>(n, i), has_coarser_points));
  std::sort(regions.begin(), regions.end(), [](const Region<D>& a, const Region<D>& b) {
    return morton<D>(a.position) < morton<D>(b.position);
  });
  return regions;
}

/// Points per axis of the grid that a level's samples lie on: that of its attributes, which may
/// reach beyond the data; at level 0 the samples of the data.
template <int D>
Index<D> sample_dims(const Shape<D>& shape, int level) {
  return level > 0 ? shape.grid_dims(level) : shape.dims;
}

/// Samples that a file holds in all its blocks, with those beyond the data.
template <int D>
std::uint64_t count_stored_samples(const Shape<D>& shape) {
  std::uint64_t n = 0;
  for (int level = 0; level < shape.n_levels; ++level) {
    std::uint64_t all = 1;
    std::uint64_t even = 1;
    for (const std::int32_t dim : sample_dims<D>(shape, level).v) {
      all *= as_size(dim);
      even *= as_size((dim + 1) / 2);
    }
    n += level == shape.n_levels - 1 ? all : all - even;
  }
  return n;
}

template <int D>
std::size_t count_points(const Region<D>& r) {
  std::size_t all = 1;
  std::size_t even = 1;
  for (std::size_t a = 0; a < as_size(D); ++a) {
    all *= as_size(r.upper[a] - r.lower[a]);
    even *= as_size((r.upper[a] + 1) / 2 - (r.lower[a] + 1) / 2);
  }
  return r.has_coarser_points ? all : all - even;
}

/// Ranges are stored in the sample type where that is an integer type, else as float32.
template <typename T>
using RangeOf = std::conditional_t<std::is_integral_v<T>, T, float>;

/// Calls f.template operator()<R>() with it.
template <typename F>
decltype(auto) visit_range_type(ScalarType storage, F&& f) {
  return visit_storage_type(storage,
                            [&]<typename T>() { return f.template operator()<RangeOf<T>>(); });
}

template <int D>
store::BlockKey key_of(Kind kind, const Region<D>& r) {
  store::BlockKey key{static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(r.level), {}};
  for (std::size_t a = 0; a < as_size(D); ++a) key.position[a] = r.position[a];
  return key;
}

/// The region's points in rows: body(q, n, stride) for each, q the first of n points that lie
/// `stride` steps of the level apart: 2 where every other point belongs to a coarser level.
template <int D, typename F>
void for_each_row(const Region<D>& r, const F& body) {
  Index<D> rows = r.upper - r.lower;
  const std::int32_t n = std::exchange(rows[0], 1);
  for (std::size_t i = 0; i < n_points<D>(rows); ++i) {
    Index<D> q = r.lower + point_of<D>(rows, i);
    std::int32_t odd = 0;
    for (std::size_t a = 1; a < as_size(D); ++a) odd |= q[a] & 1;
    if (r.has_coarser_points || odd != 0) {
      body(q, n, 1);
      continue;
    }
    const std::int32_t skipped = (q[0] & 1) == 0 ? 1 : 0;
    q[0] += skipped;
    if (n > skipped) body(q, (n - skipped + 1) / 2, 2);
  }
}

/// How many points of the region for_each_row goes through before q, one of them.
template <int D>
std::size_t place_in(const Region<D>& r, const Index<D>& q) {
  const auto n_even = [](std::int32_t lower, std::int32_t upper) {
    return as_size((upper + 1) / 2 - (lower + 1) / 2);
  };
  const std::size_t width = as_size(r.upper[0] - r.lower[0]);
  std::size_t n_rows = 0;                   // before q's
  std::size_t n_thinned = 0;                // of them, with points of a coarser level
  std::size_t all = 1;                      // rows of the axes before
  std::size_t even = 1;                     // of them, those with even coordinates
  bool is_thinned = !r.has_coarser_points;  // q's own row
  for (std::size_t a = 1; a < as_size(D); ++a) {
    n_rows += as_size(q[a] - r.lower[a]) * all;
    n_thinned = n_even(r.lower[a], q[a]) * even + ((q[a] & 1) == 0 ? n_thinned : 0);
    all *= as_size(r.upper[a] - r.lower[a]);
    even *= n_even(r.lower[a], r.upper[a]);
    is_thinned = is_thinned && (q[a] & 1) == 0;
  }
  if (r.has_coarser_points) n_thinned = 0;
  const std::size_t left_out = n_thinned * n_even(r.lower[0], r.upper[0]);
  const std::size_t in_row =
      as_size(q[0] - r.lower[0]) - (is_thinned ? n_even(r.lower[0], q[0]) : 0);
  return n_rows * width - left_out + in_row;
}

/// How many of a row's n points (see for_each_row) lie in the data: the first ones, or none.
template <int D>
std::int32_t count_inside(const Shape<D>& shape, int level, const Index<D>& q, std::int32_t n,
                          std::int32_t stride) {
  Index<D> p = q;
  for (std::int32_t& x : p.v) x <<= level;
  if (!shape.is_sample(p)) return 0;
  return std::min(n, (shape.dims[0] - 1 - p[0]) / (stride << level) + 1);
}

/// The regions of all blocks of a kind.
template <int D>
std::vector<Region<D>> all_regions(const Shape<D>& shape, Kind kind) {
  std::vector<Region<D>> regions;
  for (int level = shape.n_levels - 1; level >= (kind == Kind::samples ? 0 : 1); --level) {
    const bool is_coarsest = level == shape.n_levels - 1;
    const auto more =
        regions_of<D>(sample_dims<D>(shape, level), level, kind == Kind::samples && is_coarsest);
    regions.insert(regions.end(), more.begin(), more.end());
  }
  return regions;
}

}  // namespace lode::diamond
