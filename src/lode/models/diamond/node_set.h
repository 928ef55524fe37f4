#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Nodes that are to be refined whatever their error, and with each all that must come before it: a
/// bit for each sample, in tiles of which only those that have any take memory. Nodes with centres
/// beyond the data need no mention: they reach across its border (Shape::reaches_across), and so do
/// those that come before them.
template <int D>
class NodeSet {
 public:
  explicit NodeSet(const Shape<D>& shape) : shape_(shape), tiles_(1) {
    for (std::size_t i = 0; i < as_size(D); ++i)
      n_tiles_[i] = (shape.dims[i] - 1) / kTileEdge[i] + 1;
    tile_of_.resize(n_points<D>(n_tiles_));
  }

  [[nodiscard]] bool contains(const Index<D>& centre) const {
    return shape_.is_sample(centre) && ((word_of(centre) >> (centre[0] % kRow)) & 1U) != 0;
  }
  /// Bit i: whether the point at `first` + i along the first axis is in the set; n <= 64 of them.
  [[nodiscard]] std::uint64_t row(const Index<D>& first, std::int32_t n) const {
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (first[i] >= shape_.dims[i]) return 0;
    n = std::min(n, shape_.dims[0] - first[0]);
    if (n <= 0) return 0;
    const std::int32_t skipped = first[0] % kRow;
    std::uint64_t bits = word_of(first) >> skipped;
    if (skipped + n > kRow) {
      Index<D> next = first;
      next[0] += kRow - skipped;
      bits |= word_of(next) << (kRow - skipped);
    }
    return n == kRow ? bits : bits & ((std::uint64_t{1} << n) - 1);
  }
  /// Those in a smaller lattice, which begins at `origin`.
  [[nodiscard]] NodeSet part(const Shape<D>& shape, const Index<D>& origin) const {
    NodeSet part(shape);
    Index<D> words = shape.dims;
    words[0] = part.n_tiles_[0];
    for (std::size_t i = 0; i < n_points<D>(words); ++i) {
      Index<D> first = point_of<D>(words, i);
      first[0] *= kRow;
      const std::uint64_t bits =
          row(first + origin, std::min<std::int32_t>(kRow, shape.dims[0] - first[0]));
      if (bits != 0) part.word_at(first) = bits;
    }
    return part;
  }
  /// With its ancestors, in which on_new(centre) is called for each that was not there.
  template <typename OnNew>
  void insert(const Index<D>& centre, const OnNew& on_new) {
    std::vector<Index<D>> waiting{centre};
    while (!waiting.empty()) {
      const Index<D> p = waiting.back();
      waiting.pop_back();
      if (!shape_.is_sample(p) || common_exponent<D>(p) >= shape_.n_levels) continue;
      if (!set(p)) continue;
      on_new(p);
      for (const Index<D>& parent : parents<D>(diamond_at<D>(p), shape_.root_side()))
        waiting.push_back(parent);
    }
  }
  /// With all of another of the same lattice. How many of them were not there.
  std::uint64_t join(const NodeSet& other) {
    std::uint64_t n_new = 0;
    for (std::size_t at = 0; at < tile_of_.size(); ++at) {
      if (other.tile_of_[at] == 0) continue;
      if (tile_of_[at] == 0) tile_of_[at] = add_tile();
      Tile& own = tiles_[tile_of_[at]];
      const Tile& more = other.tiles_[other.tile_of_[at]];
      for (std::size_t i = 0; i < own.size(); ++i) {
        n_new += static_cast<std::uint64_t>(std::popcount(more[i] & ~own[i]));
        own[i] |= more[i];
      }
    }
    return n_new;
  }
  void clear() {
    tiles_.resize(1);
    std::fill(tile_of_.begin(), tile_of_.end(), 0);
  }

  /// Alone; false if it was there. `centre` is a sample.
  bool set(const Index<D>& centre) {
    std::uint64_t& word = word_at(centre);
    const std::uint64_t bit = std::uint64_t{1} << (centre[0] % kRow);
    if ((word & bit) != 0) return false;
    word |= bit;
    return true;
  }
  /// Alone, those at `first` + i along the first axis for which bit i is set; all are samples.
  void set_row(const Index<D>& first, std::uint64_t bits) {
    const std::int32_t skipped = first[0] % kRow;
    if (bits << skipped != 0) word_at(first) |= bits << skipped;
    if (skipped == 0 || bits >> (kRow - skipped) == 0) return;
    Index<D> next = first;
    next[0] += kRow - skipped;
    word_at(next) |= bits >> (kRow - skipped);
  }
  /// Takes one that is there away, alone.
  void reset(const Index<D>& centre) {
    word_at(centre) &= ~(std::uint64_t{1} << (centre[0] % kRow));
  }
  /// What it takes of memory.
  [[nodiscard]] std::uint64_t n_bytes() const {
    return tiles_.capacity() * sizeof(Tile) + tile_of_.capacity() * sizeof(std::uint32_t);
  }

 private:
  /// Of a tile: along x one word, along the other axes 8 of them.
  static constexpr std::int32_t kRow = 64;
  static constexpr std::int32_t kRows = 8;
  static constexpr Index<D> kTileEdge = [] {
    Index<D> edge = all_equal<D>(kRows);
    edge[0] = kRow;
    return edge;
  }();
  using Tile = std::array<std::uint64_t, power(as_size(kRows), D - 1)>;

  [[nodiscard]] std::size_t tile_at(const Index<D>& p) const {
    Index<D> tile;
    for (std::size_t i = 0; i < as_size(D); ++i) tile[i] = p[i] / kTileEdge[i];
    return linear_index<D>(n_tiles_, tile);
  }
  /// Of a point's row in its tile.
  [[nodiscard]] static std::size_t row_at(const Index<D>& p) {
    std::size_t at = 0;
    for (std::size_t i = as_size(D); i-- > 1;) at = at * as_size(kRows) + as_size(p[i] % kRows);
    return at;
  }
  [[nodiscard]] std::uint64_t word_of(const Index<D>& p) const {
    return tiles_[tile_of_[tile_at(p)]][row_at(p)];
  }
  [[nodiscard]] std::uint64_t& word_at(const Index<D>& p) {
    std::uint32_t& tile = tile_of_[tile_at(p)];
    if (tile == 0) tile = add_tile();
    return tiles_[tile][row_at(p)];
  }
  /// With little room for more: sets may take much of the memory there is.
  [[nodiscard]] std::uint32_t add_tile() {
    if (tiles_.size() == tiles_.capacity()) tiles_.reserve(tiles_.size() + tiles_.size() / 4 + 1);
    tiles_.emplace_back();
    return static_cast<std::uint32_t>(tiles_.size() - 1);
  }

  Shape<D> shape_;
  Index<D> n_tiles_;
  std::vector<std::uint32_t> tile_of_;  ///< By position, x fastest: which; 0 where there is none.
  std::vector<Tile> tiles_;             ///< The first is empty.
};

}  // namespace lode::diamond
