#include "lode/mappers/box_pairs.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>
#include <vector>

namespace lode {
namespace {

constexpr std::size_t kLeafBoxes = 8;
constexpr std::size_t kLeavesPerReport = 1024;

bool meet(const Box3f& a, const Box3f& b) {
  int is_meeting = 1;  // no branches: they would be guessed wrong half of the time
  for (std::size_t i = 0; i < 3; ++i)
    is_meeting &=
        static_cast<int>(a.lower[i] <= b.upper[i]) & static_cast<int>(b.lower[i] <= a.upper[i]);
  return is_meeting != 0;
}

void include(Box3f& box, const Box3f& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min(box.lower[i], other.lower[i]);
    box.upper[i] = std::max(box.upper[i], other.upper[i]);
  }
}

/// Puts two zero bits between the 21 low bits.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | (x << 32)) & 0x001f00000000ffffULL;
  x = (x | (x << 16)) & 0x001f0000ff0000ffULL;
  x = (x | (x << 8)) & 0x100f00f00f00f00fULL;
  x = (x | (x << 4)) & 0x10c30c30c30c30c3ULL;
  return (x | (x << 2)) & 0x1249249249249249ULL;
}

std::uint64_t morton_code(const Box3f& box, const Box3f& all, double scale) {
  std::uint64_t code = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double centre =
        0.5 * (static_cast<double>(box.lower[i]) + static_cast<double>(box.upper[i]));
    const double cell = (centre - static_cast<double>(all.lower[i])) * scale;
    code |= spread_bits(static_cast<std::uint64_t>(cell)) << i;
  }
  return code;
}

/// Indices of the boxes along a Morton curve. Only speed depends on it.
std::vector<std::uint32_t> sort_boxes(std::span<const Box3f> boxes) {
  Box3f all = boxes[0];
  for (const Box3f& box : boxes) include(all, box);
  double extent = 0;
  for (std::size_t i = 0; i < 3; ++i)
    extent =
        std::max(extent, static_cast<double>(all.upper[i]) - static_cast<double>(all.lower[i]));
  const double scale = extent > 0 ? 2097151.0 / extent : 0.0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    keys[i] = {morton_code(boxes[i], all, scale), static_cast<std::uint32_t>(i)};
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(boxes.size());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
  return order;
}

/// A complete binary tree over leaves of eight boxes; node i has the children 2i and 2i + 1, and
/// leaf l is node n_leaf_slots + l. Slots beyond the last leaf are never entered.
class BoxTree {
 public:
  explicit BoxTree(std::span<const Box3f> boxes) : order_(sort_boxes(boxes)) {
    sorted_.reserve(boxes.size());
    for (const std::uint32_t i : order_) sorted_.push_back(boxes[i]);
    n_leaves_ = (boxes.size() + kLeafBoxes - 1) / kLeafBoxes;
    n_slots_ = std::bit_ceil(n_leaves_);
    nodes_.resize(2 * n_slots_);
    for (std::size_t l = 0; l < n_leaves_; ++l) {
      Box3f& node = nodes_[n_slots_ + l];
      node = sorted_[l * kLeafBoxes];
      for (std::size_t i = l * kLeafBoxes; i < end_of(l); ++i) include(node, sorted_[i]);
    }
    for (std::size_t i = n_slots_ - 1; i > 0; --i) {
      if (first_leaf(2 * i) >= n_leaves_) continue;
      nodes_[i] = nodes_[2 * i];
      if (first_leaf(2 * i + 1) < n_leaves_) include(nodes_[i], nodes_[2 * i + 1]);
    }
  }

  [[nodiscard]] std::size_t n_leaves() const { return n_leaves_; }

  /// Appends the pairs of leaf l with itself and with the leaves after it.
  void find_pairs(std::size_t l, std::vector<IndexPair>& pairs) const {
    pair_within(l, pairs);
    const Box3f& box = nodes_[n_slots_ + l];
    std::array<std::size_t, 2 * 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 1;
    while (depth > 0) {
      const std::size_t node = stack[--depth];
      if (last_leaf(node) <= l || first_leaf(node) >= n_leaves_ || !meet(nodes_[node], box))
        continue;
      if (node >= n_slots_) {
        pair_leaves(l, node - n_slots_, pairs);
      } else {
        stack[depth++] = 2 * node + 1;
        stack[depth++] = 2 * node;
      }
    }
  }

 private:
  [[nodiscard]] std::size_t end_of(std::size_t l) const {
    return std::min(sorted_.size(), (l + 1) * kLeafBoxes);
  }
  [[nodiscard]] std::size_t height_of(std::size_t node) const {
    return static_cast<std::size_t>(std::bit_width(n_slots_) - std::bit_width(node));
  }
  [[nodiscard]] std::size_t first_leaf(std::size_t node) const {
    return (node << height_of(node)) - n_slots_;
  }
  [[nodiscard]] std::size_t last_leaf(std::size_t node) const {
    return first_leaf(node) + (std::size_t{1} << height_of(node)) - 1;
  }

  void add(std::size_t i, std::size_t j, std::vector<IndexPair>& pairs) const {
    if (meet(sorted_[i], sorted_[j]))
      pairs.push_back({std::min(order_[i], order_[j]), std::max(order_[i], order_[j])});
  }
  void pair_within(std::size_t l, std::vector<IndexPair>& pairs) const {
    for (std::size_t i = l * kLeafBoxes; i < end_of(l); ++i)
      for (std::size_t j = i + 1; j < end_of(l); ++j) add(i, j, pairs);
  }
  void pair_leaves(std::size_t l, std::size_t m, std::vector<IndexPair>& pairs) const {
    const Box3f& other = nodes_[n_slots_ + m];
    for (std::size_t i = l * kLeafBoxes; i < end_of(l); ++i) {
      if (!meet(sorted_[i], other)) continue;
      for (std::size_t j = m * kLeafBoxes; j < end_of(m); ++j) add(i, j, pairs);
    }
  }

  std::vector<std::uint32_t> order_;
  std::vector<Box3f> sorted_;
  std::vector<Box3f> nodes_;
  std::size_t n_leaves_ = 0;
  std::size_t n_slots_ = 0;
};

}  // namespace

Result<void> visit_box_pairs(
    std::span<const Box3f> boxes, Threads threads, Progress& progress,
    const std::function<void(std::span<const IndexPair> pairs, int worker)>& visit) {
  if (boxes.empty()) return {};
  const BoxTree tree(boxes);
  std::vector<std::vector<IndexPair>> scratch(static_cast<std::size_t>(n_workers(threads)));
  std::atomic<std::size_t> n_done{0};
  parallel_for(tree.n_leaves(), threads, 64, [&](std::size_t l, int worker) {
    if (progress.is_cancelled()) return;
    std::vector<IndexPair>& pairs = scratch[static_cast<std::size_t>(worker)];
    pairs.clear();
    tree.find_pairs(l, pairs);
    visit(pairs, worker);
    const std::size_t done = n_done.fetch_add(1, std::memory_order_relaxed) + 1;
    if (done % kLeavesPerReport == 0)
      progress.report("self-intersections",
                      static_cast<double>(done) / static_cast<double>(tree.n_leaves()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  return {};
}

}  // namespace lode
