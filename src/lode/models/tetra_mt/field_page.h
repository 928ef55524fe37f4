#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "lode/models/tetra_mt/packed_numbers.h"
#include "lode/models/tetra_mt/page_content.h"

namespace lode::tetra_mt {

/// What a page has for one field, in memory: 36 bits of facts a node, and values.
class FieldPage {
 public:
  FieldPage(const FieldContent& content, bool is_narrow);

  [[nodiscard]] double value(std::uint32_t i) const {
    return values_.read(bits_.data() + values_at_, i)[0];
  }
  [[nodiscard]] FactCodes facts(std::uint32_t i) const {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << FactCodes::kBits) - 1;
    const std::size_t at = fact_bit(i);
    std::uint64_t window = 0;
    std::memcpy(&window, bits_.data() + at / 8, sizeof window);
    window >>= at % 8;
    return {static_cast<std::uint16_t>(window & kMask),
            static_cast<std::uint16_t>(window >> FactCodes::kBits & kMask),
            static_cast<std::uint16_t>(window >> (2 * FactCodes::kBits) & kMask)};
  }
  /// Asks the memory for a node's facts.
  void prefetch(std::uint32_t i) const { __builtin_prefetch(bits_.data() + fact_bit(i) / 8); }
  [[nodiscard]] std::size_t n_bytes() const { return sizeof *this + bits_.capacity(); }

 private:
  [[nodiscard]] static std::size_t fact_bit(std::uint32_t i) {
    return std::size_t{3} * FactCodes::kBits * i;
  }

  std::vector<std::uint8_t> bits_;  ///< Of facts, then of values.
  PackedNumbers<1> values_;
  std::uint32_t values_at_ = 0;  ///< Where they begin, in bytes.
};

}  // namespace lode::tetra_mt
