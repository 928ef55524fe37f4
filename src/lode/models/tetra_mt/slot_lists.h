#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace lode::tetra_mt {

/// A list of numbers for each vertex, of which some grow while others end. What ends is used again.
class SlotLists {
 public:
  /// `counts`: how many each begins with.
  explicit SlotLists(std::span<const std::uint32_t> counts);

  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t list) const {
    return {pool_.data() + lists_[list].begin, lists_[list].size};
  }
  void add(std::uint32_t list, std::uint32_t number) {
    List& to = lists_[list];
    if (to.size == to.n_grains * kGrain) grow(to);
    pool_[to.begin + to.size++] = number;
  }
  /// The last one takes its place. Expects it there.
  void remove(std::uint32_t list, std::uint32_t number) {
    List& from = lists_[list];
    std::uint32_t* at = pool_.data() + from.begin;
    while (*at != number) ++at;
    *at = pool_[from.begin + --from.size];
  }
  /// Those that `goes(number)` is true of; the others keep their order.
  template <typename Goes>
  void remove_if(std::uint32_t list, const Goes& goes) {
    std::uint32_t* const begin = pool_.data() + lists_[list].begin;
    std::uint32_t n = 0;
    for (std::uint32_t i = 0; i < lists_[list].size; ++i) {
      const std::uint32_t number = begin[i];
      begin[n] = number;
      n += goes(number) ? 0 : 1;
    }
    lists_[list].size = n;
  }
  /// Into ascending order.
  void sort(std::uint32_t list) {
    std::uint32_t* const begin = pool_.data() + lists_[list].begin;
    std::sort(begin, begin + lists_[list].size);
  }
  void end(std::uint32_t list);

 private:
  static constexpr std::uint32_t kGrain = 8;  ///< Room is a multiple of it.

  struct List {
    std::uint64_t begin = 0;
    std::uint32_t size = 0;
    std::uint32_t n_grains = 0;  ///< Of its room.
  };

  void grow(List& list);
  void set_free(std::uint64_t begin, std::uint32_t n_grains);

  std::vector<std::uint32_t> pool_;
  std::vector<List> lists_;
  std::vector<std::vector<std::uint64_t>> free_;  ///< By grains: where room of that size begins.
};

}  // namespace lode::tetra_mt
