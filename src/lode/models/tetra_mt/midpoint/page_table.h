#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lode::tetra_mt::midpoint {

/// Nodes in a page, at most.
inline constexpr std::uint32_t kPageNodes = 256;

/// What tells the labels of a page's nodes and leaves.
struct PageCounts {
  struct Group {
    std::uint32_t epoch;
    std::uint32_t n;  ///< Nodes; at least 1.

    friend bool operator==(const Group&, const Group&) = default;
  };
  std::vector<Group> groups;   ///< By epoch, ascending.
  std::uint32_t n_leaves = 0;  ///< Of the mesh's vertices, those that its nodes bring.

  friend bool operator==(const PageCounts&, const PageCounts&) = default;
};

/// Which nodes are in which page. Nodes are numbered by epoch, and in each by page, the last one
/// first; a page has its nodes in the order of their numbers. Leaves are numbered by page, behind
/// the base's.
class PageTable {
 public:
  struct Location {
    std::uint32_t page;
    std::uint32_t place;
  };

  PageTable() = default;
  PageTable(std::uint32_t n_base_leaves, std::span<const PageCounts> pages);

  [[nodiscard]] std::uint32_t n_pages() const { return static_cast<std::uint32_t>(sizes_.size()); }
  [[nodiscard]] std::uint32_t n_nodes() const { return n_nodes_; }
  [[nodiscard]] std::uint32_t n_nodes_of(std::uint32_t page) const { return sizes_[page]; }

  /// Of a node.
  [[nodiscard]] Location locate(std::uint32_t node) const {
    std::uint32_t at = hints_[node / kHinted];
    while (runs_[at + 1].first <= node) ++at;
    return {runs_[at].page, node - runs_[at].bias};
  }
  [[nodiscard]] std::uint32_t node_at(std::uint32_t page, std::uint32_t place) const {
    std::uint32_t at = first_groups_[page];
    while (ends_[at] <= place) ++at;
    return biases_[at] + place;
  }
  /// By group of a page: what makes nodes of its places,
  [[nodiscard]] std::span<const std::uint32_t> biases_of(std::uint32_t page) const {
    return {biases_.data() + first_groups_[page], n_groups_of(page)};
  }
  /// and where it ends.
  [[nodiscard]] std::span<const std::uint16_t> ends_of(std::uint32_t page) const {
    return {ends_.data() + first_groups_[page], n_groups_of(page)};
  }
  /// Of a page, and behind the last one how many there are.
  [[nodiscard]] std::uint32_t first_leaf(std::uint32_t page) const { return first_leaves_[page]; }
  [[nodiscard]] std::uint32_t n_leaves_of(std::uint32_t page) const {
    return first_leaves_[page + 1] - first_leaves_[page];
  }
  /// Of a leaf that is not the base's.
  [[nodiscard]] std::uint32_t page_of_leaf(std::uint32_t leaf) const;

  [[nodiscard]] std::size_t n_bytes() const;

 private:
  static constexpr std::uint32_t kHinted = 64;

  /// Nodes of one epoch and one page.
  struct Run {
    std::uint32_t first;  ///< Its number.
    std::uint32_t page;
    std::uint32_t bias;  ///< As biases_.
  };

  [[nodiscard]] std::size_t n_groups_of(std::uint32_t page) const {
    return first_groups_[page + 1] - first_groups_[page];
  }

  std::uint32_t n_nodes_ = 0;
  std::vector<std::uint32_t> sizes_;            ///< By page.
  std::vector<std::uint32_t> first_groups_{0};  ///< By page; one behind the last.
  std::vector<std::uint32_t> biases_;  ///< By page and group: a node's number less its place,
  std::vector<std::uint16_t> ends_;    ///< and the place behind its last.
  std::vector<Run> runs_{};            ///< By number; one behind the last.
  std::vector<std::uint32_t> hints_;   ///< By 64 nodes: the run of the first.
  std::vector<std::uint32_t> first_leaves_{0};  ///< By page; one behind the last.
};

}  // namespace lode::tetra_mt::midpoint
