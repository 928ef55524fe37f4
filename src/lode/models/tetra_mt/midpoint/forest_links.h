#pragma once

// How the trees of a page are linked, as bits: docs/format.md, section 7.

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/models/tetra_mt/midpoint/forest_page.h"
#include "lode/models/tetra_mt/number_models.h"

namespace lode::tetra_mt::midpoint {

/// Codes children and parents of a page's nodes, from each root of the page down, the second end
/// first. Leaves are numbered as they come, and nodes of each level likewise. A writer codes what
/// is given; both make the same.
template <typename Coder>
class TreeCoder {
 public:
  TreeCoder(Coder& coder, const ForestHead& head, std::uint32_t page, const ForestContent* given,
            const std::string& what, ForestContent& made)
      : coder_(coder),
        table_(head.pages),
        n_vertices_(head.n_vertices),
        page_(page),
        given_(given),
        what_(what),
        made_(made),
        n_(table_.n_nodes_of(page)),
        next_leaf_(table_.first_leaf(page)) {}

  Result<void> run() {
    LODE_CHECK(code_levels());
    made_.children.resize(n_);
    made_.parents.resize(n_, kNone);
    while (order_.size() < n_) LODE_CHECK(code_tree());
    if (next_leaf_ != table_.first_leaf(page_ + 1))
      return fail("{}: expected {} leaves, got {}", what_, table_.n_leaves_of(page_),
                  next_leaf_ - table_.first_leaf(page_));
    for (std::uint32_t place = 0; place < n_; ++place)
      if (made_.children[place].first <= made_.children[place].second ||
          made_.children[place].first >= label_at(place) || made_.parents[place] <= label_at(place))
        return fail("{}: node {}: expected labels that fall, got {} into {} and {}", what_, place,
                    label_at(place), made_.children[place].first, made_.children[place].second);
    return {};
  }

  /// Places, as they are coded,
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }
  /// by place: which level it is of,
  [[nodiscard]] std::uint32_t level_of(std::uint32_t place) const {
    const auto above = std::ranges::upper_bound(offsets_, place);
    return static_cast<std::uint32_t>(above - offsets_.begin() - 1);
  }
  /// and of a label whether it is of the page's nodes.
  [[nodiscard]] bool is_near(std::uint32_t label) const {
    return label != kNone && label >= n_vertices_ &&
           table_.locate(label - n_vertices_).page == page_;
  }
  [[nodiscard]] std::uint32_t place_of(std::uint32_t label) const {
    return table_.locate(label - n_vertices_).place;
  }

 private:
  enum Kind : std::uint32_t { leaf, near, far };
  static constexpr std::uint32_t kKinds = 3;
  static constexpr std::uint32_t kContexts = 8;  ///< Parts of the levels.

  /// What a node splits into, and is still to be coded.
  struct Waiting {
    std::uint32_t parent;  ///< Its place.
    bool is_first;
  };
  /// Pages that links lead to, the last one last.
  struct FarPages {
    std::vector<std::uint32_t> pages;
    NumberModel ranks;
    WideModel steps;
    std::uint32_t last_new = 0;
  };

  [[nodiscard]] std::uint32_t label_at(std::uint32_t place) const {
    return n_vertices_ + table_.node_at(page_, place);
  }
  [[nodiscard]] Kind kind_of(std::uint32_t label) const {
    return label < n_vertices_ ? leaf : is_near(label) ? near : far;
  }

  /// Of how many nodes each is.
  Result<void> code_levels() {
    for (std::uint32_t n_left = n_; n_left > 0; n_left -= made_.levels.back()) {
      const std::size_t at = made_.levels.size();
      const std::uint32_t given = given_ != nullptr ? given_->levels[at] - 1 : 0;
      const std::uint32_t n = 1 + sizes_[std::min<std::size_t>(at, 3)].code(coder_, given);
      if (n > n_left) return fail("{}: expected a level of up to {}, got {}", what_, n_left, n);
      offsets_.push_back(n_ - n_left);
      made_.levels.push_back(n);
    }
    filled_.resize(made_.levels.size(), 0);
    return {};
  }

  Result<void> code_tree() {
    LODE_CHECK(code_root());
    while (!waiting_.empty()) {
      const Waiting next = waiting_.back();
      waiting_.pop_back();
      const std::uint32_t above = level_of(next.parent);
      std::uint32_t given = 0;
      if (given_ != nullptr) {
        const Children& children = given_->children[next.parent];
        given = above - 1 - level_of(place_of(next.is_first ? children.first : children.second));
      }
      const std::size_t height = kContexts * above / made_.levels.size();
      const std::uint32_t gap = gaps_[height].code(coder_, given);
      if (gap >= above) return fail("{}: expected a level below {}, got more", what_, above);
      LODE_TRY(const std::uint32_t place, take_place(above - 1 - gap));
      Children& children = made_.children[next.parent];
      (next.is_first ? children.first : children.second) = label_at(place);
      made_.parents[place] = label_at(next.parent);
      LODE_CHECK(code_children(place));
    }
    return {};
  }
  Result<std::uint32_t> take_place(std::uint32_t level) {
    if (level >= made_.levels.size() || filled_[level] == made_.levels[level])
      return fail("{}: expected as many nodes of each level as there are, got more", what_);
    const std::uint32_t place = offsets_[level] + filled_[level]++;
    order_.push_back(place);
    return place;
  }
  /// Roots of the page ascend: so a writer finds them.
  Result<void> code_root() {
    std::uint32_t given_level = last_root_level_;
    if (given_ != nullptr) {
      while (is_near(given_->parents[next_root_])) ++next_root_;
      given_level = level_of(next_root_++);
    }
    const std::uint32_t step = root_gaps_.code(coder_, given_level - last_root_level_);
    last_root_level_ += step;
    LODE_TRY(const std::uint32_t place, take_place(last_root_level_));
    const std::uint32_t given = given_ != nullptr ? given_->parents[place] : kNone;
    if (coder_.bit(is_base_, given == kNone)) {
      made_.parents[place] = kNone;
    } else {
      LODE_TRY(made_.parents[place], code_far(far_parents_, given));
    }
    return code_children(place);
  }
  Result<void> code_children(std::uint32_t place) {
    const Children given = given_ != nullptr ? given_->children[place] : Children{0, 0};
    const std::size_t height = kContexts * level_of(place) / made_.levels.size();
    const std::uint32_t kinds =
        kinds_[height].code(coder_, kKinds * kind_of(given.first) + kind_of(given.second));
    const std::array<std::uint32_t, 2> ends{kinds / kKinds, kinds % kKinds};
    if (ends[0] > far || (ends[0] == leaf && ends[1] != leaf))
      return fail("{}: node {}: expected ends of three kinds, got {}", what_, place, kinds);
    for (std::size_t end = 2; end-- > 0;) {
      std::uint32_t& label = end == 0 ? made_.children[place].first : made_.children[place].second;
      if (ends[end] == leaf) {
        if (next_leaf_ == table_.first_leaf(page_ + 1))
          return fail("{}: expected {} leaves, got more", what_, table_.n_leaves_of(page_));
        label = next_leaf_++;
      } else if (ends[end] == far) {
        LODE_TRY(label, code_far(far_children_, end == 0 ? given.first : given.second));
      }
    }
    for (const std::size_t end : {0U, 1U})
      if (ends[end] == near) waiting_.push_back({place, end == 0});
    return {};
  }

  /// By how lately its page was linked to, or by its number; then by place.
  Result<std::uint32_t> code_far(FarPages& models, std::uint32_t given) {
    PageTable::Location there{0, 0};
    if (given_ != nullptr) there = table_.locate(given - n_vertices_);
    std::vector<std::uint32_t>& pages = models.pages;
    const auto n = static_cast<std::uint32_t>(pages.size());
    const auto at = std::find(pages.rbegin(), pages.rend(), there.page) - pages.rbegin();
    const std::uint32_t rank = models.ranks.code(coder_, static_cast<std::uint32_t>(at));
    if (rank > n) return fail("{}: expected one of {} pages, got {}", what_, n, rank);
    if (rank == n) {
      const std::uint32_t from = n == 0 ? page_ : models.last_new;
      const auto step = static_cast<std::int32_t>(there.page - from);
      const std::uint64_t code = models.steps.code(coder_, folded(step));
      there.page = from + static_cast<std::uint32_t>(unfolded(static_cast<std::uint32_t>(code)));
      if (there.page >= table_.n_pages() || there.page == page_)
        return fail("{}: expected another of {} pages, got {}", what_, table_.n_pages(),
                    there.page);
      models.last_new = there.page;
    } else {
      there.page = pages[n - 1 - rank];
      pages.erase(pages.end() - 1 - static_cast<std::ptrdiff_t>(rank));
    }
    pages.push_back(there.page);
    const std::uint32_t n_there = table_.n_nodes_of(there.page);
    there.place = static_cast<std::uint32_t>(code_below(coder_, n_there, there.place));
    if (there.place >= n_there)
      return fail("{}: expected one of {} nodes, got {}", what_, n_there, there.place);
    return n_vertices_ + table_.node_at(there.page, there.place);
  }

  Coder& coder_;
  const PageTable& table_;
  std::uint32_t n_vertices_;
  std::uint32_t page_;
  const ForestContent* given_;
  const std::string& what_;
  ForestContent& made_;
  std::uint32_t n_;
  std::vector<std::uint32_t> offsets_;  ///< By level: its first place,
  std::vector<std::uint32_t> filled_;   ///< and how many are taken.
  std::uint32_t next_leaf_;
  std::uint32_t next_root_ = 0;  ///< For a writer: where the next one is looked for.
  std::uint32_t last_root_level_ = 0;
  std::vector<std::uint32_t> order_;
  std::vector<Waiting> waiting_;
  FarPages far_children_;
  FarPages far_parents_;
  BitModel is_base_;
  NumberModel root_gaps_;
  std::array<CountModel<4>, 4> sizes_;  ///< By level.
  std::array<SymbolModel<4>, kContexts> kinds_;
  std::array<NumberModel, kContexts> gaps_;
};

}  // namespace lode::tetra_mt::midpoint
