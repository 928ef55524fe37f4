#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/page_content.h"

namespace lode::tetra_mt::midpoint {

/// What a page of nodes has, spread out; by place. What is known of a node before it is split is in
/// the page of its parent.
struct ForestContent {
  std::vector<std::uint32_t> levels;  ///< LabelOrder's: of how many nodes each is.
  std::vector<NodeRecord> records;    ///< Without the facts of those whose parent is elsewhere.
  std::vector<Children> children;
  std::vector<std::uint32_t> parents;  ///< Labels; kNone of roots.
  /// By place: facts of children that are nodes of other pages, 0 of others.
  std::vector<std::array<std::uint32_t, 2>> far_facts;
  ExactLeaves exact;
  Lists<std::uint32_t> regions;  ///< By place: Hierarchy::regions_of().

  [[nodiscard]] std::uint32_t n_nodes() const { return static_cast<std::uint32_t>(records.size()); }
  friend bool operator==(const ForestContent&, const ForestContent&) = default;
};

[[nodiscard]] ForestContent content_of(const Hierarchy& hierarchy, std::uint32_t page);

/// What a page has of a further field, in memory as in files: 16 bytes a node, by place.
struct FieldPage {
  struct Node {
    std::int32_t difference = 0;  ///< Of the ends' values.
    Place place = Place::middle;  ///< Whose value the vertex has.
    /// Of its ends, without balls; 0 of leaves.
    std::array<std::uint32_t, 2> child_facts{};

    friend bool operator==(const Node&, const Node&) = default;
  };
  std::vector<Node> nodes;
  ExactValues exact;

  friend bool operator==(const FieldPage&, const FieldPage&) = default;
};

/// The same in memory, with links of 16 bits: about 42 bytes a node.
class ForestPage {
 public:
  /// `page`: of `table`, which must outlive it.
  ForestPage(const ForestContent& content, const PageTable& table, std::uint32_t page,
             std::uint32_t n_vertices);

  [[nodiscard]] const NodeRecord& record(std::uint32_t place) const { return records_[place]; }
  [[nodiscard]] Children children(std::uint32_t place) const {
    return {label_of(links_[place].first), label_of(links_[place].second)};
  }
  /// kNone of roots.
  [[nodiscard]] std::uint32_t parent(std::uint32_t place) const {
    const Link link = links_[place].parent;
    return link < kFirstLeaf ? label_of(link) : far_parents_[link - kFirstLeaf];
  }
  /// Facts of a node's children, 0 of leaves.
  [[nodiscard]] std::array<std::uint32_t, 2> child_facts(std::uint32_t place) const {
    return {facts_of(links_[place].first), facts_of(links_[place].second)};
  }
  [[nodiscard]] const LeafOffset* find_exact(std::uint32_t leaf) const { return exact_.find(leaf); }
  [[nodiscard]] std::span<const std::uint32_t> regions(std::uint32_t place) const;
  [[nodiscard]] std::size_t n_bytes() const;

 private:
  /// Below kFirstLeaf a place, then a leaf of the page, from kFirstFar on one of far_.
  using Link = std::uint16_t;
  static constexpr Link kFirstLeaf = kPageNodes;
  static constexpr Link kFirstFar = 3 * kPageNodes;
  struct Links {
    Link first;
    Link second;
    Link parent;  ///< Behind places, one of far_parents_.
  };
  struct Far {
    std::uint32_t label;
    std::uint32_t facts;
  };

  [[nodiscard]] std::uint32_t label_of(Link link) const {
    if (link < kFirstLeaf) return n_vertices_ + link + biases_[groups_[link]];
    if (link < kFirstFar) return first_leaf_ + (link - kFirstLeaf);
    return far_[link - kFirstFar].label;
  }
  [[nodiscard]] std::uint32_t facts_of(Link link) const {
    if (link < kFirstLeaf) return records_[link].facts;
    return link < kFirstFar ? 0 : far_[link - kFirstFar].facts;
  }

  std::vector<NodeRecord> records_;
  std::vector<Links> links_;
  std::vector<std::uint8_t> groups_;  ///< By place,
  std::span<const std::uint32_t>
      biases_;            ///< and by group what makes nodes of places: the table's.
  std::vector<Far> far_;  ///< Children in other pages,
  std::vector<std::uint32_t> far_parents_;  ///< and parents, kNone of roots.
  std::uint32_t n_vertices_;
  std::uint32_t first_leaf_;
  ExactLeaves exact_;
  std::vector<std::uint32_t> mixed_;  ///< Places with regions, ascending,
  Lists<std::uint32_t> regions_;      ///< and these.
};

/// `nodes`: the page.
[[nodiscard]] FieldPage field_page_of(const ForestHead& head, const ForestPage& nodes,
                                      const FurtherField& field, std::uint32_t page);

}  // namespace lode::tetra_mt::midpoint
