#include "lode/models/tetra_mt/midpoint/page_table.h"

#include <algorithm>

namespace lode::tetra_mt::midpoint {

PageTable::PageTable(std::uint32_t n_base_leaves, std::span<const PageCounts> pages) {
  struct Keyed {
    std::uint32_t epoch;
    std::uint32_t after;  ///< How many pages are after its own.
    std::uint32_t group;
    auto operator<=>(const Keyed&) const = default;
  };
  std::vector<Keyed> keyed;
  first_leaves_.back() = n_base_leaves;
  for (const PageCounts& page : pages) {
    first_leaves_.push_back(first_leaves_.back() + page.n_leaves);
    const auto after = static_cast<std::uint32_t>(pages.size() - 1 - sizes_.size());
    std::uint32_t size = 0;
    for (const PageCounts::Group& group : page.groups) {
      keyed.push_back({group.epoch, after, static_cast<std::uint32_t>(keyed.size())});
      size += group.n;
      ends_.push_back(static_cast<std::uint16_t>(size));
    }
    first_groups_.push_back(static_cast<std::uint32_t>(keyed.size()));
    sizes_.push_back(size);
  }
  biases_.resize(keyed.size());
  std::ranges::sort(keyed);
  for (const Keyed& k : keyed) {
    const auto page = static_cast<std::uint32_t>(pages.size() - 1 - k.after);
    const std::uint32_t begin = k.group == first_groups_[page] ? 0U : ends_[k.group - 1];
    biases_[k.group] = n_nodes_ - begin;
    runs_.push_back({n_nodes_, page, biases_[k.group]});
    n_nodes_ += ends_[k.group] - begin;
    while (std::uint64_t{kHinted} * hints_.size() < n_nodes_)
      hints_.push_back(static_cast<std::uint32_t>(runs_.size() - 1));
  }
  runs_.push_back({n_nodes_, 0, 0});
}

std::uint32_t PageTable::page_of_leaf(std::uint32_t leaf) const {
  const auto above = std::ranges::upper_bound(first_leaves_, leaf);
  return static_cast<std::uint32_t>(above - first_leaves_.begin() - 1);
}

std::size_t PageTable::n_bytes() const {
  return runs_.size() * sizeof(Run) + ends_.size() * sizeof(std::uint16_t) +
         (sizes_.size() + first_groups_.size() + biases_.size() + hints_.size() +
          first_leaves_.size()) *
             sizeof(std::uint32_t);
}

}  // namespace lode::tetra_mt::midpoint
