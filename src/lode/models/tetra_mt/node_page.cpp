#include "lode/models/tetra_mt/node_page.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <span>

namespace lode::tetra_mt {
namespace {

constexpr int kCountBits = 4;
constexpr std::uint32_t kLongCount = (1U << kCountBits) - 1;
constexpr int kLongCountBits = 8;

void write_count(BitWriter& bits, std::uint32_t n) {
  bits.write(std::min(n, kLongCount), kCountBits);
  if (n >= kLongCount) bits.write(n, kLongCountBits);
}

std::uint32_t read_count(BitReader& bits) {
  const std::uint32_t n = bits.read(kCountBits);
  return n < kLongCount ? n : bits.read(kLongCountBits);
}

}  // namespace

class NodePage::Packer {
 public:
  Packer(NodePage& page, const PageContent& content, const PageShape& shape)
      : page_(page), content_(content), shape_(shape) {}

  void run() {
    list_pages();
    list_masks();
    BitWriter bits;
    const auto n = static_cast<std::uint32_t>(content_.n_nodes());
    const auto position = [&](std::uint32_t i, std::size_t k) {
      return content_.positions[i].v[k];
    };
    page_.positions_ = PackedNumbers<3>(n, shape_.has_narrow_positions, position);
    page_.positions_.write(n, position, bits);
    BitWriter node;
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::size_t begin = bits.align_to(kUnitBits) / kUnitBits;
      if (i % kGroup == 0) page_.begins_.push_back(static_cast<std::uint32_t>(begin));
      write_node(i, node);
      const std::size_t length = node.align_to(kUnitBits) / kUnitBits;
      page_.lengths_.push_back(static_cast<std::uint8_t>(std::min<std::size_t>(length, kLong)));
      if (length >= kLong)
        bits.write(static_cast<std::uint32_t>(length) + kLengthBits / kUnitBits, kLengthBits);
      bits.take_all(node);
      page_.has_long_ = page_.has_long_ || length >= kLong;
    }
    page_.lengths_.resize((page_.lengths_.size() + kGroup - 1) / kGroup * kGroup);
    page_.bits_ = std::move(bits).take();
  }

 private:
  struct Numbered {
    std::uint32_t begin;
    std::uint32_t number;
  };

  [[nodiscard]] std::uint32_t begin_of(std::uint32_t vertex) const {
    const std::uint32_t n_base = shape_.n_base_vertices;
    const std::uint32_t first = vertex < n_base ? 0 : n_base;
    return first + (vertex - first) / kPageNodes * kPageNodes;
  }
  void list_pages() {
    std::vector<std::uint32_t> begins;
    const auto add = [&](std::uint32_t vertex) {
      if (const std::uint32_t begin = begin_of(vertex); begin != page_.own_)
        begins.push_back(begin);
    };
    for (const std::uint32_t v : content_.targets) add(v);
    for (const auto* nodes : {&content_.children.items, &content_.parents.items})
      for (const std::uint32_t node : *nodes) add(shape_.n_base_vertices + node);
    std::ranges::sort(begins);
    for (std::size_t i = 0; i < begins.size(); ++i) {
      if (i == 0 || begins[i] != begins[i - 1]) places_.push_back({begins[i], 0});
      ++places_.back().number;
    }
    std::vector<Numbered> by_links = places_;
    std::ranges::stable_sort(by_links, std::ranges::greater(), &Numbered::number);
    for (std::uint32_t i = 0; i < by_links.size(); ++i) {
      page_.pages_.push_back(by_links[i].begin);
      std::ranges::lower_bound(places_, by_links[i].begin, {}, &Numbered::begin)->number = i;
    }
    if (page_.pages_.size() > 1) page_.n_page_bits_ = bits_for(page_.pages_.size() - 1);
  }
  void list_masks() {
    if (shape_.n_regions <= 1 || content_.region_masks.empty()) return;
    std::vector<std::uint64_t>& masks = page_.masks_;
    masks = content_.region_masks;
    std::ranges::sort(masks);
    masks.erase(std::unique(masks.begin(), masks.end()), masks.end());
    masks.shrink_to_fit();
    if (masks.size() > 1)
      page_.n_mask_bits_ = static_cast<std::uint8_t>(bits_for(masks.size() - 1));
  }
  void write_vertex(std::uint32_t vertex, BitWriter& bits) const {
    const std::uint32_t begin = begin_of(vertex);
    bits.write(begin == page_.own_ ? 0 : 1, 1);
    if (begin != page_.own_) {
      const std::uint32_t place =
          std::ranges::lower_bound(places_, begin, {}, &Numbered::begin)->number;
      const bool is_few = place < 1U << kFewBits;
      bits.write(is_few ? 0 : 1, 1);
      bits.write(place, is_few ? kFewBits : page_.n_page_bits_);
    }
    bits.write(vertex - begin, kPageBits);
  }
  void write_node(std::uint32_t i, BitWriter& bits) const {
    bits.write(content_.boxes[i], BoxCodes::kBits);
    if (page_.n_mask_bits_ > 0) {
      const auto place = std::ranges::lower_bound(page_.masks_, content_.region_masks[i]);
      bits.write(static_cast<std::uint32_t>(place - page_.masks_.begin()), page_.n_mask_bits_);
    }
    const auto children = content_.children[i];
    const auto parents = content_.parents[i];
    write_count(bits, static_cast<std::uint32_t>(children.size()));
    write_count(bits, static_cast<std::uint32_t>(parents.size()));
    bits.write(content_.n_discovered[i], bits_for(children.size()));
    write_target(i, bits);
    for (const std::uint32_t child : children) write_vertex(shape_.n_base_vertices + child, bits);
    for (const std::uint32_t parent : parents) write_vertex(shape_.n_base_vertices + parent, bits);
    if (!children.empty()) write_makers(i, bits);
    if (page_.n_region_bits_ == 0) return;
    bits.write(content_.regions[i].empty() ? 0 : 1, 1);
    for (const std::uint32_t region : content_.regions[i]) bits.write(region, page_.n_region_bits_);
  }
  void write_target(std::uint32_t i, BitWriter& bits) const {
    const auto parents = content_.parents[i];
    const std::uint32_t target = content_.targets[i];
    const auto found = target < shape_.n_base_vertices
                           ? parents.end()
                           : std::ranges::find(parents, target - shape_.n_base_vertices);
    bits.write(found != parents.end() ? 1 : 0, 1);
    if (found != parents.end())
      bits.write(static_cast<std::uint32_t>(found - parents.begin()), bits_for(parents.size() - 1));
    else
      write_vertex(target, bits);
  }
  void write_makers(std::uint32_t i, BitWriter& bits) const {
    const auto children = content_.children[i];
    const auto makers = content_.makers[i];
    const bool has_reference = std::ranges::find(makers, children.size()) != makers.end();
    bits.write(has_reference ? 1 : 0, 1);
    const int n_maker_bits = bits_for(children.size() - (has_reference ? 0 : 1));
    for (const std::uint8_t maker : makers) bits.write(maker, n_maker_bits);
  }

  NodePage& page_;
  const PageContent& content_;
  const PageShape& shape_;
  std::vector<Numbered> places_;  ///< In pages_, ascending by where they begin.
};

NodePage::NodePage(const PageContent& content, std::uint32_t number, const PageShape& shape)
    : own_(shape.n_base_vertices + number * kPageNodes),
      first_(shape.n_base_vertices),
      n_region_bits_(shape.n_labels > 1 ? bits_for(shape.n_labels - 1) : 0) {
  Packer(*this, content, shape).run();
  begins_.shrink_to_fit();
  lengths_.shrink_to_fit();
  pages_.shrink_to_fit();
}

NodePage::Links::Links(const NodePage& page, std::uint32_t i) : Links(page, i, page.begin_of(i)) {}

NodePage::Links::Links(const NodePage& page, std::uint32_t i, std::size_t begin)
    : page_(&page),
      end_(kUnitBits * page.end_of(i, begin)),
      bits_(page.reader_at(begin)),
      n_children_(
          (bits_.skip(BoxCodes::kBits + std::size_t{page.n_mask_bits_}), read_count(bits_))),
      n_parents_(read_count(bits_)),
      n_discovered_(bits_.read(bits_for(n_children_))),
      is_target_parent_(bits_.read(1) != 0),
      target_(is_target_parent_ ? bits_.read(bits_for(n_parents_ - std::size_t{1}))
                                : page.read_vertex(bits_)),
      lists_at_(bits_.at()) {}

void NodePage::Links::start_makers() {
  if (n_children_ == 0) return;
  const bool has_reference = bits_.read(1) != 0;
  n_maker_bits_ = bits_for(n_children_ - (has_reference ? 0 : 1));
}

std::size_t NodePage::n_bytes() const {
  const auto bytes = [](const auto& items) { return items.capacity() * sizeof(items[0]); };
  return sizeof *this + bytes(masks_) + bytes(bits_) + bytes(begins_) + bytes(lengths_) +
         bytes(pages_);
}

}  // namespace lode::tetra_mt
