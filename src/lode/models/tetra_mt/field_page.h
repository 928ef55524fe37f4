#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>

#include "lode/models/tetra_mt/page_content.h"

namespace lode::tetra_mt {

/// What a page has for one field, in memory: values, and 36 bits of facts a node.
class FieldPage {
 public:
  FieldPage(const FieldContent& content, bool is_narrow);

  [[nodiscard]] double value(std::uint32_t i) const {
    if (is_narrow_) return static_cast<double>(std::bit_cast<float>(words_[i]));
    double number = 0;
    std::memcpy(&number, &words_[std::size_t{2} * i], sizeof number);
    return number;
  }
  [[nodiscard]] FactCodes facts(std::uint32_t i) const {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << FactCodes::kBits) - 1;
    const std::size_t at = std::size_t{3} * FactCodes::kBits * i;
    std::uint64_t window = 0;
    std::memcpy(&window, facts_at(at), sizeof window);
    window >>= at % 8;
    return {static_cast<std::uint16_t>(window & kMask),
            static_cast<std::uint16_t>(window >> FactCodes::kBits & kMask),
            static_cast<std::uint16_t>(window >> (2 * FactCodes::kBits) & kMask)};
  }
  /// Asks the memory for a node's facts.
  void prefetch(std::uint32_t i) const {
    __builtin_prefetch(facts_at(std::size_t{3} * FactCodes::kBits * i));
  }
  [[nodiscard]] std::size_t n_bytes() const;

 private:
  /// `bit`: of those of facts.
  [[nodiscard]] const std::byte* facts_at(std::size_t bit) const {
    return reinterpret_cast<const std::byte*>(words_.get()) +
           (is_narrow_ ? 4 : 8) * std::size_t{n_} + bit / 8;
  }
  [[nodiscard]] std::size_t n_words() const;

  std::unique_ptr<std::uint32_t[]> words_;  ///< Of values, then of facts.
  std::uint32_t n_;                         ///< Nodes.
  bool is_narrow_;                          ///< float32 holds the values.
};

}  // namespace lode::tetra_mt
