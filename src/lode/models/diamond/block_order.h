#pragma once

// The order of the blocks in a .lode file: as a build that goes through a volume once can write
// them; docs/decisions/0011-parts-and-borders.md.

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "lode/models/diamond/block_layout.h"

namespace lode::diamond {

/// Levels up to this one are written chunk by chunk, the coarser ones behind all chunks.
inline constexpr int kChunkLevel = 2;
/// Samples per edge of a chunk: a block of level kChunkLevel and all finer ones in its place.
template <int D>
inline constexpr std::int32_t kChunkEdge = kBlockEdge<D> << kChunkLevel;

template <int D>
Index<D> chunk_counts(const Shape<D>& shape) {
  Index<D> n;
  for (std::size_t i = 0; i < as_size(D); ++i)
    n[i] = std::max(1, (shape.dims[i] - 1 + kChunkEdge<D> - 1) / kChunkEdge<D>);
  return n;
}

/// The position of a chunk in the order of the file: x fastest, then the last axis, along which
/// successive parts have most in common.
template <int D>
Index<D> chunk_at(const Shape<D>& shape, std::size_t number) {
  const Index<D> n = chunk_counts<D>(shape);
  Index<D> order = n;
  std::swap(order[1], order[as_size(D - 1)]);
  Index<D> chunk = point_of<D>(order, number);
  std::swap(chunk[1], chunk[as_size(D - 1)]);
  return chunk;
}

/// The samples of the chunks lower <= position < upper: the last one of an axis goes on to its end.
template <int D>
LatticeBox<D> samples_of_chunks(const Shape<D>& shape, const LatticeBox<D>& chunks) {
  const Index<D> n = chunk_counts<D>(shape);
  LatticeBox<D> box{chunks.lower * kChunkEdge<D>, {}};
  for (std::size_t i = 0; i < as_size(D); ++i)
    box.upper[i] = chunks.upper[i] == n[i] ? shape.dims[i] : chunks.upper[i] * kChunkEdge<D>;
  return box;
}

/// Blocks that are written one after the other: of samples, or of all a region's attributes.
template <int D>
struct BlockGroup {
  bool is_samples = false;
  Region<D> region;
};

namespace detail {

template <int D>
void append_level(const Shape<D>& shape, int level, const LatticeBox<D>& positions,
                  std::vector<BlockGroup<D>>& out) {
  for (const bool is_samples : {true, false}) {
    if (!is_samples && level == 0) continue;
    const bool has_coarser_points = is_samples && level == shape.n_levels - 1;
    const Index<D> dims = is_samples ? sample_dims<D>(shape, level) : shape.grid_dims(level);
    const Index<D> n = block_counts<D>(dims);
    LatticeBox<D> box = positions;
    for (std::size_t i = 0; i < as_size(D); ++i) box.upper[i] = std::min(box.upper[i], n[i]);
    const std::size_t first = out.size();
    const Index<D> edges = box.upper - box.lower;
    for (std::size_t i = 0; i < n_points<D>(edges); ++i)
      out.push_back({is_samples, region_at<D>(dims, level, box.lower + point_of<D>(edges, i),
                                              has_coarser_points)});
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
              [](const BlockGroup<D>& a, const BlockGroup<D>& b) {
                return morton<D>(a.region.position) < morton<D>(b.region.position);
              });
  }
}

}  // namespace detail

/// The blocks of a chunk, coarse levels first.
template <int D>
std::vector<BlockGroup<D>> chunk_blocks(const Shape<D>& shape, const Index<D>& chunk) {
  std::vector<BlockGroup<D>> groups;
  for (int level = std::min(kChunkLevel, shape.n_levels - 1); level >= 0; --level) {
    const std::int32_t n = std::int32_t{1} << (kChunkLevel - level);
    detail::append_level<D>(shape, level, {chunk * n, chunk * n + all_equal<D>(n)}, groups);
  }
  return groups;
}

/// Those behind all chunks, finer levels first: what is read first is near the directory.
template <int D>
std::vector<BlockGroup<D>> coarse_blocks(const Shape<D>& shape) {
  std::vector<BlockGroup<D>> groups;
  for (int level = kChunkLevel + 1; level < shape.n_levels; ++level)
    detail::append_level<D>(shape, level,
                            {{}, all_equal<D>(std::numeric_limits<std::int32_t>::max())}, groups);
  return groups;
}

}  // namespace lode::diamond
