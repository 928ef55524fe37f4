#pragma once

// What splits a page's vertices, as bits: docs/format.md, section 7.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/midpoint/star_order.h"
#include "lode/models/tetra_mt/number_models.h"

namespace lode::tetra_mt::midpoint {

/// Codes differences of codes, each kind with models of its own.
template <typename Coder>
class StepCoder {
 public:
  StepCoder(Coder& coder, const std::string& what) : coder_(coder), what_(what) {}

  /// In place; returns how many bits its size has. `view`: below 8, what that depends on;
  /// `n_leaves`: of the two whose difference it is.
  Result<std::uint32_t> code(std::uint32_t view, std::uint32_t n_leaves, std::int32_t& step) {
    const std::uint32_t given =
        step < 0 ? 0U - static_cast<std::uint32_t>(step) : static_cast<std::uint32_t>(step);
    const std::uint32_t n =
        n_bits_[view].code(coder_, static_cast<std::uint32_t>(std::bit_width(given)));
    if (n == 0) {
      step = 0;
      return n;
    }
    std::uint32_t n_zeros =
        std::min(static_cast<std::uint32_t>(std::countr_zero(given | 1U << 31)), kMostZeros);
    n_zeros = n_zeros_[n_leaves].code(coder_, n_zeros);
    if (n_zeros >= n) return fail("{}: expected fewer than {} zeros, got {}", what_, n, n_zeros);
    // Of the rest the highest bit is known, and the lowest where it is what ends the zeros.
    std::uint32_t size = given >> n_zeros;
    const std::uint32_t n_left = n - n_zeros;
    const bool is_odd = n_zeros < kMostZeros && n_left > 1;
    const auto n_coded = static_cast<int>(n_left - 1 - (is_odd ? 1 : 0));
    size = static_cast<std::uint32_t>(
        code_behind_highest(coder_, behind_[n], n_coded, size >> (is_odd ? 1 : 0)));
    size = (is_odd ? 2 * size + 1 : size) << n_zeros;
    const bool is_negative = coder_.bit(is_negative_, step < 0);
    step = static_cast<std::int32_t>(is_negative ? 0U - size : size);
    return n;
  }

 private:
  static constexpr std::uint32_t kMostZeros = 15;

  Coder& coder_;
  const std::string& what_;
  std::array<SymbolModel<5>, 8> n_bits_;
  std::array<SymbolModel<4>, 3> n_zeros_;
  std::array<std::array<BitModel, 8>, 32> behind_;
  BitModel is_negative_;
};

/// Codes what of a record is not facts. Readers are given records of zeros.
template <typename Coder>
class RecordCoder {
 public:
  RecordCoder(Coder& coder, const std::string& what)
      : coder_(coder),
        what_(what),
        axes_{{{coder, what}, {coder, what}, {coder, what}, {coder, what}}} {}

  /// One more, in place. `n_leaves`: of its ends.
  Result<void> code(NodeRecord& record, std::uint32_t n_leaves) {
    const Placement given = record.placement();
    const auto position = positions_.code(coder_, static_cast<std::uint32_t>(given.position));
    const auto value = values_[position].code(coder_, static_cast<std::uint32_t>(given.value));
    if (std::max(position, value) > static_cast<std::uint32_t>(Place::second))
      return fail("{}: expected one of three places, got {} and {}", what_, position, value);
    std::uint32_t beside = 0;
    for (std::size_t axis = 0; axis < 4; ++axis) {
      LODE_TRY(beside, axes_[axis].code(axis == 0 ? n_leaves : beside / 4, n_leaves,
                                        record.difference[axis]));
    }
    std::uint64_t mask = record.mask[0] | std::uint64_t{record.mask[1] & kHighMask} << 32;
    LODE_CHECK(code_mask(mask));
    record.mask = {static_cast<std::uint32_t>(mask),
                   static_cast<std::uint32_t>(mask >> 32) | position << 28 | value << 30};
    return {};
  }

 private:
  static constexpr std::uint32_t kHighMask = (1U << 28) - 1;

  /// How many bits it has to the highest that is 1, and those below in view of three before.
  Result<void> code_mask(std::uint64_t& mask) {
    const std::uint32_t n =
        mask_sizes_.code(coder_, static_cast<std::uint32_t>(std::bit_width(mask)));
    if (n > kMaxStar) return fail("{}: expected masks of {} bits, got {}", what_, kMaxStar, n);
    std::uint64_t made = 0;
    std::uint32_t seen = 1;
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const bool bit = coder_.bit(mask_bits_[seen], (mask >> i & 1) != 0);
      made |= std::uint64_t{bit ? 1U : 0U} << i;
      seen = seen >= 8 ? 8 | (2 * seen & 7) | (bit ? 1U : 0U) : 2 * seen + (bit ? 1U : 0U);
    }
    mask = n == 0 ? 0 : made | std::uint64_t{1} << (n - 1);
    return {};
  }

  Coder& coder_;
  const std::string& what_;
  SymbolModel<2> positions_;
  std::array<SymbolModel<2>, 4> values_;
  std::array<StepCoder<Coder>, 4> axes_;
  SymbolModel<6> mask_sizes_;
  std::array<BitModel, 16> mask_bits_;
};

/// A coder of the value places of a field: whose value a vertex has.
template <typename Coder>
Result<Place> code_place(Coder& coder, SymbolModel<2>& model, Place given,
                         const std::string& what) {
  const auto place = model.code(coder, static_cast<std::uint32_t>(given));
  if (place <= static_cast<std::uint32_t>(Place::second)) return static_cast<Place>(place);
  return fail("{}: expected one of three places, got {}", what, place);
}

/// Codes facts of children by those of their parent, which are none smaller, or where these are in
/// another page by the last ones. `kFacts`: 4, or 3 without balls.
template <typename Coder, std::size_t kFacts = 4>
class FactsCoder {
 public:
  FactsCoder(Coder& coder, const NodeCodes& codes, const std::string& what)
      : coder_(coder), codes_(codes), what_(what) {}

  /// `own`: of the parent, where it is known. Either child may have none: no place.
  Result<void> code(const std::uint32_t* own, std::uint32_t* first, std::uint32_t* second) {
    std::size_t role = first != nullptr && second != nullptr ? 1 : 0;
    for (std::uint32_t* facts : {first, second}) {
      if (facts == nullptr) continue;
      LODE_TRY(role, own != nullptr ? code_below(*own, role, *facts) : code_beside(role, *facts));
    }
    return {};
  }

 private:
  static constexpr std::array<std::uint32_t, 4> kLimits{256, 64, 64, 4096};
  using Four = std::array<std::uint32_t, 4>;

  /// So that what states more is more: lows from above.
  [[nodiscard]] static Four four_of(std::uint32_t word) {
    const NodeCodes::Parts parts = NodeCodes::parts(word);
    return {parts.error, 63 - parts.low, parts.high, parts.radius};
  }
  Result<void> set(const Four& four, std::uint32_t& word) const {
    for (std::size_t i = 0; i < kFacts; ++i)
      if (four[i] >= kLimits[i])
        return fail("{}: expected facts below {}, got {}", what_, kLimits[i], four[i]);
    const NodeCodes::Parts parts{four[0], 63 - four[1], four[2], four[3]};
    if (!codes_.has_range(parts))
      return fail("{}: expected ranges, got {} to {}", what_, parts.low, parts.high);
    word = NodeCodes::word(parts);
    return {};
  }

  /// Returns the role of what is coded next: 0 an only child, 1 the first, 2 and 3 the second one,
  /// by whether the first has the parent's error.
  Result<std::size_t> code_below(std::uint32_t own, std::size_t role, std::uint32_t& facts) {
    const Four all = four_of(own);
    Four found = four_of(facts);
    for (std::size_t i = 0; i < kFacts; ++i) {
      Below& models = below_[role][i];
      const bool is_less = coder_.bit(models.is_less, found[i] != all[i]);
      found[i] = is_less ? all[i] - 1 - models.sizes.code(coder_, all[i] - 1 - found[i]) : all[i];
    }
    last_ = found;
    LODE_CHECK(set(found, facts));
    return found[0] == all[0] ? std::size_t{3} : std::size_t{2};
  }
  Result<std::size_t> code_beside(std::size_t role, std::uint32_t& facts) {
    Four found = four_of(facts);
    for (std::size_t i = 0; i < kFacts; ++i) {
      const auto step = static_cast<std::int32_t>(found[i] - last_[i]);
      found[i] = last_[i] + static_cast<std::uint32_t>(
                                unfolded(beside_[role / 2][i].code(coder_, folded(step))));
    }
    last_ = found;
    LODE_CHECK(set(found, facts));
    return std::size_t{2};
  }

  struct Below {
    BitModel is_less;
    NumberModel sizes;
  };

  Coder& coder_;
  const NodeCodes& codes_;
  const std::string& what_;
  Four last_{};
  std::array<std::array<Below, 4>, 4> below_;  ///< By role and fact.
  std::array<std::array<NumberModel, 4>, 2> beside_;
};

}  // namespace lode::tetra_mt::midpoint
