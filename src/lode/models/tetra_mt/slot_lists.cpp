#include "lode/models/tetra_mt/slot_lists.h"

#include <algorithm>

namespace lode::tetra_mt {

SlotLists::SlotLists(std::span<const std::uint32_t> counts) : lists_(counts.size()) {
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    lists_[i] = {n, 0, (counts[i] + kGrain - 1) / kGrain};
    n += std::uint64_t{lists_[i].n_grains} * kGrain;
  }
  pool_.resize(n);
}

void SlotLists::end(std::uint32_t list) {
  set_free(lists_[list].begin, lists_[list].n_grains);
  lists_[list].size = 0;
  lists_[list].n_grains = 0;
}

void SlotLists::grow(List& list) {
  const std::uint32_t n_grains = list.n_grains + 1 + list.n_grains / 4;
  std::uint64_t begin = pool_.size();
  if (n_grains < free_.size() && !free_[n_grains].empty()) {
    begin = free_[n_grains].back();
    free_[n_grains].pop_back();
  } else {
    pool_.resize(begin + std::uint64_t{n_grains} * kGrain);
  }
  std::copy_n(pool_.begin() + static_cast<std::ptrdiff_t>(list.begin), list.size,
              pool_.begin() + static_cast<std::ptrdiff_t>(begin));
  set_free(list.begin, list.n_grains);
  list.begin = begin;
  list.n_grains = n_grains;
}

void SlotLists::set_free(std::uint64_t begin, std::uint32_t n_grains) {
  if (n_grains == 0) return;
  if (n_grains >= free_.size()) free_.resize(n_grains + 1);
  free_[n_grains].push_back(begin);
}

}  // namespace lode::tetra_mt
