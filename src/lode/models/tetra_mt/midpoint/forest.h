#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/forest_page.h"

namespace lode::tetra_mt::midpoint {

/// What splits a vertex.
struct Split {
  Children children;
  Code difference{};
  Placement placement;
  std::uint64_t mask = 0;                      ///< NodeRecord's, without the placement.
  std::array<std::uint32_t, 2> child_facts{};  ///< 0 of leaves.
  std::span<const std::uint32_t> regions;      ///< Hierarchy::regions_of().
};

/// A Hierarchy: all in memory, or in pages from a file, each when it is looked at first, to stay.
/// Const members are safe from many threads.
class Forest {
 public:
  /// What pages have, checked against the head; called by one thread at a time.
  struct Load {
    std::function<Result<ForestContent>(const ForestHead& head, std::uint32_t page)> nodes;
    /// Of fields but the first.
    std::function<Result<FieldRoots>(const ForestHead& head, std::size_t field)> roots;
    std::function<Result<FieldPage>(const ForestHead& head, std::size_t field, std::uint32_t page,
                                    const ForestPage& nodes)>
        field;
    std::function<Result<WorldPage>(const ForestHead& head, std::size_t field, std::uint32_t page)>
        world_errors;
  };

  /// All of it, in memory, but for what only files need.
  explicit Forest(Hierarchy hierarchy);
  Forest(ForestHead head, Load load);
  Forest(Forest&&) noexcept;
  Forest& operator=(Forest&&) noexcept;
  ~Forest();

  [[nodiscard]] const ForestHead& head() const { return *head_; }
  /// Of a node, with its ends' values and facts of a field; without children where its page cannot
  /// be loaded.
  [[nodiscard]] Split split(std::uint32_t node, std::size_t field = 0) const;
  [[nodiscard]] Children children(std::uint32_t node) const;
  /// The vertex that splits into a node's and another; kNone of the base's.
  [[nodiscard]] std::uint32_t parent(std::uint32_t node) const;
  /// A word of NodeCodes, of a node: it is in its parent's page, or the base's.
  [[nodiscard]] std::uint32_t facts(std::uint32_t node, std::size_t field = 0) const;
  /// Of a node; infinite where the field has none, or they cannot be loaded.
  [[nodiscard]] float world_error(std::uint32_t node, std::size_t field) const;
  /// Of a place in the head's roots.
  [[nodiscard]] Code root_code(std::size_t place, std::size_t field = 0) const;
  [[nodiscard]] std::uint32_t root_word(std::size_t place, std::size_t field = 0) const;
  /// Of a node's vertex, found from the base down: one step for each vertex between.
  [[nodiscard]] Code code_of(std::uint32_t node, std::size_t field = 0) const;
  /// Of a vertex whose code is known.
  [[nodiscard]] Vec3d position(std::uint32_t label, const Code& code) const;
  [[nodiscard]] double value(std::uint32_t label, const Code& code, std::size_t field = 0) const;

  /// Of a file's: a page; none where it cannot be loaded.
  [[nodiscard]] const ForestPage* page(std::uint32_t number) const;
  /// Fails where something could not be loaded: nodes of such pages are as if they had nothing.
  [[nodiscard]] Result<void> check() const;
  /// What the paper counts, of what is in memory: links, offsets, values, masks and facts; of pages
  /// their table, too.
  [[nodiscard]] std::size_t n_node_bytes() const;
  [[nodiscard]] std::uint32_t n_pages_loaded() const;
  /// Of a field: of the first those of nodes.
  [[nodiscard]] std::uint32_t n_pages_loaded(std::size_t field) const;

 private:
  struct Pages;
  struct FieldPages;

  const ForestPage* load(std::uint32_t number) const;
  /// Likewise, of a field but the first.
  [[nodiscard]] const FieldPage* page(std::size_t field, std::uint32_t number) const;
  [[nodiscard]] const FieldRoots* roots(std::size_t field) const;
  [[nodiscard]] const LeafOffset* find_exact(std::uint32_t leaf) const;
  [[nodiscard]] const double* find_exact(std::uint32_t leaf, std::size_t field) const;

  std::unique_ptr<const Hierarchy> whole_;   ///< None of a file's.
  std::unique_ptr<const ForestHead> paged_;  ///< This is, then.
  const ForestHead* head_;
  WorldCodes world_codes_;
  std::unique_ptr<Pages> pages_;
};

}  // namespace lode::tetra_mt::midpoint
