#include "lode/models/tetra_mt/slot_lists.h"

#include <algorithm>

namespace lode::tetra_mt {

SlotLists::SlotLists(std::span<const std::uint32_t> counts)
    : begins_(counts.size()), sizes_(counts.size(), 0), classes_(counts.size()) {
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    begins_[i] = n;
    classes_[i] = (counts[i] + kGrain - 1) / kGrain;
    n += capacity(static_cast<std::uint32_t>(i));
  }
  pool_.resize(n);
}

void SlotLists::end(std::uint32_t list) {
  set_free(begins_[list], classes_[list]);
  sizes_[list] = 0;
  classes_[list] = 0;
}

void SlotLists::grow(std::uint32_t list) {
  const std::uint32_t size_class = classes_[list] + 1 + classes_[list] / 4;
  std::uint64_t begin = pool_.size();
  if (size_class < free_.size() && !free_[size_class].empty()) {
    begin = free_[size_class].back();
    free_[size_class].pop_back();
  } else {
    pool_.resize(begin + std::uint64_t{size_class} * kGrain);
  }
  std::copy_n(pool_.begin() + static_cast<std::ptrdiff_t>(begins_[list]), sizes_[list],
              pool_.begin() + static_cast<std::ptrdiff_t>(begin));
  set_free(begins_[list], classes_[list]);
  begins_[list] = begin;
  classes_[list] = size_class;
}

void SlotLists::set_free(std::uint64_t begin, std::uint32_t size_class) {
  if (size_class == 0) return;
  if (size_class >= free_.size()) free_.resize(size_class + 1);
  free_[size_class].push_back(begin);
}

}  // namespace lode::tetra_mt
