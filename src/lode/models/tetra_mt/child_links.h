#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/far_links.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/page_tree.h"

namespace lode::tetra_mt {

struct ChildModels {
  static constexpr std::uint32_t kFew = 6;  ///< Contexts tell apart counts up to this.

  /// By group, whether the one before is near, and how many children there are.
  std::array<std::array<std::array<BitModel, kFew + 1>, 3>, 2> is_near;
  std::array<NumberModel, 2> first_near;
  std::array<NumberModel, 2> next_near;
  /// By whether it is near, how many children have it, and how many are left.
  std::array<std::array<std::array<BitModel, 4>, 4>, 2> is_shared;
};

/// Codes children of a page's nodes: first those they discover, which makes trees; then in the
/// order of these the others, that are mostly children of children, too. Places are in the page.
template <typename Coder>
class ChildLinks {
 public:
  /// `far`: has its table. n_children: by node.
  ChildLinks(Coder& coder, ChildModels& models, FarLinks<Coder>& far, const PageShape& shape,
             std::uint32_t number, std::span<const std::uint32_t> n_children,
             const std::string& what)
      : coder_(coder),
        models_(models),
        far_(far),
        n_base_(shape.n_base_vertices),
        first_(number * kPageNodes),
        number_(number),
        n_children_(n_children),
        n_(static_cast<std::uint32_t>(n_children.size())),
        what_(what),
        far_seen_(far.vertices().size()),
        near_seen_(n_),
        lists_(n_) {}

  /// `given`: for a writer. Fills the children of `made`, which has their numbers discovered.
  Result<void> run(const PageContent* given, PageContent& made) {
    for (std::uint32_t i = 0; i < n_; ++i) {
      const std::uint32_t n = made.n_discovered[i];
      given_.assign(n, 0);
      if (given != nullptr) std::ranges::copy(given->children[i].first(n), given_.begin());
      LODE_CHECK(code_list(i, Group::discovered, lists_[i]));
      made.children.items.insert(made.children.items.end(), lists_[i].begin(), lists_[i].end());
      made.children.end_list();
    }
    tree_ = PageTree::of(made, number_);
    if (tree_.order.size() < n_)
      return fail("{}: expected nodes that do not discover each other", what_);
    for (const std::uint16_t i : tree_.order) {
      given_.assign(n_children_[i] - made.n_discovered[i], 0);
      if (given != nullptr)
        std::ranges::copy(given->children[i].subspan(made.n_discovered[i]), given_.begin());
      LODE_CHECK(code_others(i));
    }
    made.children = {};
    for (const auto& list : lists_) {
      made.children.items.insert(made.children.items.end(), list.begin(), list.end());
      made.children.end_list();
    }
    return {};
  }
  /// Of the page, once all is coded.
  [[nodiscard]] const PageTree& tree() const { return tree_; }

 private:
  enum Group : std::uint8_t { discovered, further };
  static constexpr std::uint32_t kFew = ChildModels::kFew;
  /// Of a node, for the one whose others are coded, if that is `by`.
  struct Seen {
    std::uint32_t by = 0xFFFFFFFF;
    std::uint32_t n_times = 0;  ///< That it waits; 0: it was asked for, or is a child.
  };

  [[nodiscard]] bool is_near(std::uint32_t node) const { return node - first_ < n_; }
  [[nodiscard]] Seen& seen_of(std::uint32_t node) {
    if (is_near(node)) return near_seen_[node - first_];
    const auto far = far_.vertices();
    return far_seen_[static_cast<std::size_t>(std::ranges::lower_bound(far, n_base_ + node) -
                                              far.begin())];
  }

  Result<void> code_others(std::uint16_t i) {
    const std::size_t n_discovered = lists_[i].size();
    is_done_[i] = true;
    near_seen_[i] = {i, 0};
    candidates_.clear();
    for (const std::uint32_t child : lists_[i]) seen_of(child) = {i, 0};
    for (std::size_t k = 0; k < n_discovered; ++k) add_children_of(lists_[i][k], i);
    code_shared(i);
    rest_.clear();
    LODE_CHECK(code_list(i, Group::further, rest_));
    std::vector<std::uint32_t>& list = lists_[i];
    list.insert(list.end(), rest_.begin(), rest_.end());
    const auto begin = list.begin() + static_cast<std::ptrdiff_t>(n_discovered);
    std::sort(begin, list.end());
    rest_ = list;
    std::ranges::sort(rest_);
    if (std::ranges::adjacent_find(rest_) == rest_.end()) return {};
    return fail("{}: node {}: expected children that differ", what_, i);
  }
  /// Asks for all children of children that are known, and of those that come of this; takes them
  /// out of what is given.
  void code_shared(std::uint16_t i) {
    while (!given_.empty() && !candidates_.empty()) {
      const std::uint32_t node = candidates_.front();
      std::ranges::pop_heap(candidates_, std::greater());
      candidates_.pop_back();
      const std::uint32_t n_times = std::exchange(seen_of(node).n_times, 0);
      auto& models = models_.is_shared[is_near(node) ? 1 : 0][std::min(n_times, 4U) - 1];
      const auto at = std::ranges::find(given_, node);
      if (!coder_.bit(models[std::min<std::size_t>(given_.size(), 4) - 1], at != given_.end()))
        continue;
      given_.erase(Coder::kReads ? given_.begin() : at);
      lists_[i].push_back(node);
      add_children_of(node, i);
    }
  }
  /// Those of a node whose children are known.
  void add_children_of(std::uint32_t node, std::uint16_t i) {
    if (!is_near(node) || node - first_ == i || !is_done_[node - first_]) return;
    for (const std::uint32_t child : lists_[node - first_]) {
      Seen& seen = seen_of(child);
      if (seen.by == i && seen.n_times == 0) continue;
      const bool waits = seen.by == i;
      seen = {i, waits ? seen.n_times + 1 : 1};
      if (waits) continue;
      candidates_.push_back(child);
      std::ranges::push_heap(candidates_, std::greater());
    }
  }

  /// As many as there are given.
  Result<void> code_list(std::uint32_t i, Group group, std::vector<std::uint32_t>& made) {
    std::uint32_t last_place = n_;  // n_: none
    std::uint32_t n_far = 0;
    std::size_t last = 0;  // 0: none, 1: near, 2: far
    for (const std::uint32_t given : given_) {
      BitModel& model = models_.is_near[group][last][std::min(n_children_[i], kFew)];
      const bool is_child_near = coder_.bit(model, is_near(given));
      last = is_child_near ? 1 : 2;
      if (is_child_near) {
        LODE_TRY(last_place, code_near(i, group, last_place, given - first_));
        made.push_back(first_ + last_place);
        continue;
      }
      LODE_TRY(const std::uint32_t vertex,
               far_.code(FarLinks<Coder>::child, n_far++, n_base_ + given));
      if (vertex < n_base_)
        return fail("{}: node {}: expected a link to a node, got vertex {}", what_, i, vertex);
      made.push_back(vertex - n_base_);
    }
    return {};
  }
  /// The first one from the node's own place, which it is not, others from the last one on.
  Result<std::uint32_t> code_near(std::uint32_t i, Group group, std::uint32_t last,
                                  std::uint32_t given) {
    std::uint32_t found = 0;
    if (last == n_) {
      const auto step = static_cast<std::int32_t>(given - i);
      const std::int32_t code =
          unfolded(models_.first_near[group].code(coder_, folded(step > 0 ? step - 1 : step)));
      found = i + static_cast<std::uint32_t>(code >= 0 ? code + 1 : code);
    } else {
      const std::uint32_t skipped = last < i && given > i ? 1 : 0;
      found = last + 1 + models_.next_near[group].code(coder_, given - last - 1 - skipped);
      if (last < i && found >= i) ++found;
    }
    if (found < n_) return found;
    return fail("{}: node {}: expected a link to one of {} nodes, got {}", what_, i, n_, found);
  }

  Coder& coder_;
  ChildModels& models_;
  FarLinks<Coder>& far_;
  std::uint32_t n_base_;
  std::uint32_t first_;  ///< Node.
  std::uint32_t number_;
  std::span<const std::uint32_t> n_children_;
  std::uint32_t n_;
  const std::string& what_;
  std::vector<Seen> far_seen_;   ///< By far vertex, ascending, and
  std::vector<Seen> near_seen_;  ///< by place: seen_of().
  std::vector<std::vector<std::uint32_t>> lists_;
  PageTree tree_;
  std::array<bool, kPageNodes> is_done_{};  ///< Whether its list is whole.
  std::vector<std::uint32_t> given_;        ///< Of the list that is coded; a reader's are zeros.
  std::vector<std::uint32_t> candidates_;   ///< Those that wait: a heap, the smallest first.
  std::vector<std::uint32_t> rest_;
};

}  // namespace lode::tetra_mt
