#pragma once

#include <array>
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
    return {pool_.data() + begins_[list], sizes_[list]};
  }
  void add(std::uint32_t list, std::uint32_t number) {
    if (sizes_[list] == capacity(list)) grow(list);
    pool_[begins_[list] + sizes_[list]++] = number;
  }
  /// The last one takes its place. Expects it there.
  void remove(std::uint32_t list, std::uint32_t number) {
    std::uint32_t* at = pool_.data() + begins_[list];
    while (*at != number) ++at;
    *at = pool_[begins_[list] + --sizes_[list]];
  }
  /// Those that `goes(number)` is true of; the others keep their order.
  template <typename Goes>
  void remove_if(std::uint32_t list, const Goes& goes) {
    std::uint32_t* const begin = pool_.data() + begins_[list];
    std::uint32_t n = 0;
    for (std::uint32_t i = 0; i < sizes_[list]; ++i) {
      const std::uint32_t number = begin[i];
      begin[n] = number;
      n += goes(number) ? 0 : 1;
    }
    sizes_[list] = n;
  }
  void end(std::uint32_t list);

 private:
  static constexpr std::uint32_t kGrain = 8;  ///< Capacities are multiples of it.

  [[nodiscard]] std::uint32_t capacity(std::uint32_t list) const { return classes_[list] * kGrain; }
  void grow(std::uint32_t list);
  void set_free(std::uint64_t begin, std::uint32_t size_class);

  std::vector<std::uint32_t> pool_;
  std::vector<std::uint64_t> begins_;
  std::vector<std::uint32_t> sizes_;
  std::vector<std::uint32_t> classes_;            ///< Capacities, in grains.
  std::vector<std::vector<std::uint64_t>> free_;  ///< By class: where room of that size begins.
};

}  // namespace lode::tetra_mt
