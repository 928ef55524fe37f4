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
  /// What a page has, checked against the head; called by one thread at a time.
  using Load = std::function<Result<ForestContent>(const ForestHead& head, std::uint32_t page)>;

  /// All of it, in memory, but for what only files need.
  explicit Forest(Hierarchy hierarchy);
  Forest(ForestHead head, Load load);
  Forest(Forest&&) noexcept;
  Forest& operator=(Forest&&) noexcept;
  ~Forest();

  [[nodiscard]] const ForestHead& head() const { return *head_; }
  /// Of a node; without children where its page cannot be loaded.
  [[nodiscard]] Split split(std::uint32_t node) const;
  [[nodiscard]] Children children(std::uint32_t node) const;
  /// The vertex that splits into a node's and another; kNone of the base's.
  [[nodiscard]] std::uint32_t parent(std::uint32_t node) const;
  /// A word of NodeCodes, of a node: it is in its parent's page, or the base's.
  [[nodiscard]] std::uint32_t facts(std::uint32_t node) const;
  /// Of a node's vertex, found from the base down: one step for each vertex between.
  [[nodiscard]] Code code_of(std::uint32_t node) const;
  /// Of a vertex whose code is known.
  [[nodiscard]] Vec3d position(std::uint32_t label, const Code& code) const;
  [[nodiscard]] double value(std::uint32_t label, const Code& code) const;

  /// Fails where something could not be loaded: nodes of such pages are as if they had nothing.
  [[nodiscard]] Result<void> check() const;
  /// What the paper counts, of what is in memory: links, offsets, values, masks and facts; of pages
  /// their table, too.
  [[nodiscard]] std::size_t n_node_bytes() const;
  [[nodiscard]] std::uint32_t n_pages_loaded() const;

 private:
  struct Pages;

  /// None where it cannot be loaded.
  [[nodiscard]] const ForestPage* page(std::uint32_t number) const;
  const ForestPage* load(std::uint32_t number) const;
  [[nodiscard]] const LeafOffset* find_exact(std::uint32_t leaf) const;

  std::unique_ptr<const Hierarchy> whole_;   ///< None of a file's.
  std::unique_ptr<const ForestHead> paged_;  ///< This is, then.
  const ForestHead* head_;
  std::unique_ptr<Pages> pages_;
};

}  // namespace lode::tetra_mt::midpoint
