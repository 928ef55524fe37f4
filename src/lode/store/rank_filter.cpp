#include "lode/store/rank_filter.h"

#include <algorithm>

#include "lode/core/flat_index.h"
#include "lode/store/elements.h"

namespace lode::store {
namespace {

constexpr std::size_t kMaxValues = 65536;

template <typename T>
std::optional<RankedElements> rank(std::span<const std::byte> raw) {
  const std::size_t n = raw.size() / sizeof(T);
  const std::size_t n_most = std::min(kMaxValues, n / 4);
  FlatIndex index;
  std::vector<T> values;
  std::vector<std::uint32_t> numbers(n);
  for (std::size_t i = 0; i < n; ++i) {
    const T value = load_element<T>(raw.data() + i * sizeof(T));
    numbers[i] = index.find(value);
    if (numbers[i] != FlatIndex::kNone) continue;
    if (values.size() == n_most) return {};
    numbers[i] = static_cast<std::uint32_t>(values.size());
    index.insert(value, numbers[i]);
    values.push_back(value);
  }
  std::ranges::sort(values);
  std::vector<std::uint16_t> rank_of(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    rank_of[index.find(values[i])] = static_cast<std::uint16_t>(i);
  RankedElements ranked{std::vector<std::byte>(values.size() * sizeof(T)),
                        std::vector<std::byte>(n * sizeof(std::uint16_t))};
  for (std::size_t i = 0; i < values.size(); ++i)
    store_element(ranked.values.data() + i * sizeof(T), values[i]);
  for (std::size_t i = 0; i < n; ++i)
    store_element(ranked.ranks.data() + i * sizeof(std::uint16_t), rank_of[numbers[i]]);
  return ranked;
}

}  // namespace

std::optional<RankedElements> rank_elements(std::span<const std::byte> raw,
                                            std::size_t element_size) {
  if (element_size == sizeof(std::uint32_t)) return rank<std::uint32_t>(raw);
  return rank<std::uint64_t>(raw);
}

bool restore_ranked(const RankedElements& ranked, std::size_t element_size,
                    std::span<std::byte> raw) {
  return visit_element(element_size, [&]<typename T>(T) {
    const std::size_t n_values = ranked.values.size() / sizeof(T);
    for (std::size_t i = 0; i < raw.size() / sizeof(T); ++i) {
      const auto at = load_element<std::uint16_t>(ranked.ranks.data() + 2 * i);
      if (at >= n_values) return false;
      store_element(raw.data() + i * sizeof(T),
                    load_element<T>(ranked.values.data() + at * sizeof(T)));
    }
    return true;
  });
}

}  // namespace lode::store
