#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "lode/models/tetra_mt/bit_stream.h"
#include "lode/models/tetra_mt/packed_numbers.h"
#include "lode/models/tetra_mt/page_content.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// Of what numbers pages are made.
struct PageShape {
  std::uint32_t n_base_vertices = 0;
  std::uint32_t n_nodes = 0;
  std::uint32_t n_labels = 1;         ///< Regions, or patches and none, whichever are more.
  bool has_narrow_positions = false;  ///< float32 holds them.
  std::uint32_t n_regions = 1;        ///< Where there are several, nodes have masks of them.

  /// Of nodes.
  [[nodiscard]] std::uint32_t n_pages() const { return n_pages_of(n_nodes); }
  /// Of nodes, then of the base's vertices.
  [[nodiscard]] std::uint32_t n_vertex_pages() const {
    return n_pages() + n_pages_of(n_base_vertices);
  }
};

/// Vertices of a page: of nodes, or, numbered after those, of the base's.
struct VertexRange {
  std::uint32_t first = 0;
  std::uint32_t n = 0;
};
[[nodiscard]] inline VertexRange vertices_of(const PageShape& shape, std::uint32_t page) {
  const bool is_of_nodes = page < shape.n_pages();
  const std::uint32_t at = (is_of_nodes ? page : page - shape.n_pages()) * kPageNodes;
  const std::uint32_t n = is_of_nodes ? shape.n_nodes : shape.n_base_vertices;
  return {(is_of_nodes ? shape.n_base_vertices : 0) + at, std::min(kPageNodes, n - at)};
}
[[nodiscard]] inline std::uint32_t page_of(const PageShape& shape, std::uint32_t vertex) {
  return vertex < shape.n_base_vertices ? shape.n_pages() + vertex / kPageNodes
                                        : (vertex - shape.n_base_vertices) / kPageNodes;
}

/// A page in memory, packed: for each node its position, 22 bits of its box, which of the page's
/// masks of regions it has, where there are several, and its links. A link to a node or vertex of
/// the page takes 10 bits; one to another page 14 where that is one of the eight with most links,
/// else as many as the number of such pages asks for; a target that is the vertex of a parent its
/// place among these.
class NodePage {
 public:
  /// `content` is as PageContent says: sorted, with numbers that `shape` has.
  NodePage(const PageContent& content, std::uint32_t number, const PageShape& shape);

  [[nodiscard]] Vec3d position(std::uint32_t i) const { return {positions_.read(bits_.data(), i)}; }
  [[nodiscard]] std::uint32_t box(std::uint32_t i) const {
    return reader_at(begin_of(i)).read(BoxCodes::kBits);
  }

  /// PageContent's; kAllRegions where there are none.
  [[nodiscard]] std::uint64_t region_mask(std::uint32_t i) const {
    if (masks_.empty()) return kAllRegions;
    if (n_mask_bits_ == 0) return masks_[0];
    BitReader bits = reader_at(begin_of(i));
    bits.skip(BoxCodes::kBits);
    return masks_[bits.read(n_mask_bits_)];
  }

  /// Reads the links of a node, in this order.
  class Links {
   public:
    Links(const NodePage& page, std::uint32_t i);

    /// A vertex; at any time.
    [[nodiscard]] std::uint32_t target() const {
      if (!is_target_parent_) return target_;
      BitReader bits(page_->bits_.data(), 0);
      bits.skip(lists_at_);
      for (std::uint32_t k = 0; k < n_children_ + target_; ++k) page_->skip_vertex(bits);
      return page_->read_vertex(bits);
    }
    /// The place among the parents of the one whose vertex the target is, where it is one's.
    [[nodiscard]] std::optional<std::uint32_t> target_parent() const {
      return is_target_parent_ ? std::optional(target_) : std::nullopt;
    }
    [[nodiscard]] std::uint32_t n_children() const { return n_children_; }
    [[nodiscard]] std::uint32_t n_discovered() const { return n_discovered_; }
    [[nodiscard]] std::uint32_t n_parents() const { return n_parents_; }
    /// A child, then the next one; after the last one a parent; only nodes.
    [[nodiscard]] std::uint32_t next_node() { return page_->read_vertex(bits_) - page_->first_; }
    void skip_nodes(std::uint32_t n) {
      for (std::uint32_t k = 0; k < n; ++k) page_->skip_vertex(bits_);
    }
    /// After all of them; then for each tetrahedron a place among the children, or n_children().
    void start_makers();
    /// Whether there are makers of so many.
    [[nodiscard]] bool have_makers(std::size_t n) const {
      return bits_.at() + n * static_cast<std::size_t>(n_maker_bits_) <= end_;
    }
    [[nodiscard]] std::uint32_t next_maker() { return bits_.read(n_maker_bits_); }
    /// After those: whether there are regions, and then each of the tetrahedra with an edge.
    [[nodiscard]] bool start_regions() { return page_->n_region_bits_ > 0 && bits_.read(1) != 0; }
    [[nodiscard]] std::uint32_t next_region() { return bits_.read(page_->n_region_bits_); }
    /// Whether there are regions of so many.
    [[nodiscard]] bool have_regions(std::size_t n) const {
      return bits_.at() + n * static_cast<std::size_t>(page_->n_region_bits_) <= end_;
    }

   private:
    Links(const NodePage& page, std::uint32_t i, std::size_t begin);

    const NodePage* page_;
    std::size_t end_;  ///< Of the node's links, in bits.
    BitReader bits_;
    std::uint32_t n_children_;
    std::uint32_t n_parents_;
    std::uint32_t n_discovered_;
    bool is_target_parent_;  ///< Its target is the vertex of a parent,
    std::uint32_t target_;   ///< whose place this is; else the vertex.
    std::size_t lists_at_;   ///< Where children begin, in bits.
    int n_maker_bits_ = 0;
  };

  [[nodiscard]] Links links(std::uint32_t i) const { return {*this, i}; }
  /// Asks the memory for what is read of a node, about.
  void prefetch(std::uint32_t i) const {
    const std::uint32_t group = i / kGroup;
    const std::size_t begin = begins_[group];
    const std::size_t end = group + 1 < begins_.size() ? begins_[group + 1] : begin;
    const std::size_t at = begin + (end - begin) * (i % kGroup) / kGroup;
    __builtin_prefetch(&bits_[at * kUnitBits / 8]);
    __builtin_prefetch(&lengths_[std::size_t{group} * kGroup]);
  }
  [[nodiscard]] std::size_t n_bytes() const;

 private:
  class Packer;
  static constexpr std::uint32_t kGroup = 32;  ///< Nodes of which one has a begin.
  static constexpr int kUnitBits = 4;          ///< Nodes begin at whole units of so many.
  static constexpr std::uint8_t kLong = 0xFF;  ///< Instead of what takes as many units, or more.
  static constexpr int kLengthBits = 16;       ///< Then of what this takes, before it.
  static constexpr int kFewBits = 3;           ///< For the pages with most links.

  /// At a unit of bits_.
  [[nodiscard]] BitReader reader_at(std::size_t unit) const {
    BitReader bits(bits_.data(), 0);
    bits.skip(unit * kUnitBits);
    return bits;
  }
  /// Where a node's box and links begin in bits_, in units.
  [[nodiscard]] std::size_t begin_of(std::uint32_t i) const {
    const std::uint32_t first = i / kGroup * kGroup;
    std::size_t begin = begins_[i / kGroup];
    if (!has_long_) return begin + sum_of(&lengths_[first], i - first);
    for (std::uint32_t k = first; k < i; ++k)
      begin += lengths_[k] == kLong ? long_at(begin) : lengths_[k];
    return lengths_[i] == kLong ? begin + kLengthBits / kUnitBits : begin;
  }
  /// Where they end.
  [[nodiscard]] std::size_t end_of(std::uint32_t i, std::size_t begin) const {
    constexpr std::size_t kLengthUnits = kLengthBits / kUnitBits;
    if (lengths_[i] != kLong) return begin + lengths_[i];
    return begin - kLengthUnits + long_at(begin - kLengthUnits);
  }
  /// Of the first n of a group, eight at once.
  [[nodiscard]] static std::size_t sum_of(const std::uint8_t* lengths, std::uint32_t n) {
    std::uint64_t sums = 0;  // four of 16 bits
    for (std::uint32_t k = 0; k < kGroup; k += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, lengths + k, sizeof eight);
      const std::uint32_t n_wanted = std::min(n - std::min(n, k), 8U);
      eight &= n_wanted == 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << 8 * n_wanted) - 1;
      constexpr std::uint64_t kEven = 0x00FF00FF00FF00FFU;
      sums += (eight & kEven) + (eight >> 8 & kEven);
    }
    return static_cast<std::uint16_t>((sums * 0x0001000100010001U) >> 48);
  }
  [[nodiscard]] std::size_t long_at(std::size_t begin) const {
    return reader_at(begin).read(kLengthBits);
  }
  /// How a link to a vertex begins: its own page, one of the few, or any. Which of them no
  /// processor can guess, so all are read in the same way.
  struct Form {
    std::uint32_t n_kind_bits;
    std::uint32_t n_page_bits;
  };
  [[nodiscard]] Form form_of(std::uint64_t window) const {
    const auto kind = static_cast<std::uint32_t>(window & 3);
    const std::uint32_t is_other = kind & 1;
    const std::uint32_t is_any = kind >> 1 & is_other;
    const auto n_bits = static_cast<std::uint32_t>(n_page_bits_);
    return {1 + is_other, is_any * n_bits + (is_other - is_any) * kFewBits};
  }
  [[nodiscard]] std::uint32_t read_vertex(BitReader& bits) const {
    const std::uint64_t window = bits.window();
    const Form form = form_of(window);
    const std::uint64_t rest = window >> form.n_kind_bits;
    const std::uint64_t page = rest & ((std::uint64_t{1} << form.n_page_bits) - 1);
    const std::uint32_t* const begin = (window & 1) != 0 ? pages_.data() + page : &own_;
    bits.skip(form.n_kind_bits + form.n_page_bits + kPageBits);
    return *begin + static_cast<std::uint32_t>(rest >> form.n_page_bits & (kPageNodes - 1));
  }
  void skip_vertex(BitReader& bits) const {
    const Form form = form_of(bits.window());
    bits.skip(form.n_kind_bits + form.n_page_bits + kPageBits);
  }

  PackedNumbers<3> positions_;
  std::vector<std::uint64_t> masks_;  ///< That differ, ascending.
  std::vector<std::uint8_t> bits_;    ///< Of positions, then of boxes and links.
  std::vector<std::uint32_t> begins_;
  std::vector<std::uint8_t> lengths_;  ///< Units of a node's box and links; whole groups.
  /// First vertices of other pages that links lead to, those with most links first.
  std::vector<std::uint32_t> pages_;
  std::uint32_t own_;             ///< The page's first vertex.
  std::uint32_t first_;           ///< The first vertex that is a node's.
  bool has_long_ = false;         ///< Lengths.
  std::uint8_t n_mask_bits_ = 0;  ///< Of a mask's place, behind the box.
  int n_page_bits_ = 0;
  int n_region_bits_;  ///< 0 where there is one region and no patch.
};

}  // namespace lode::tetra_mt
