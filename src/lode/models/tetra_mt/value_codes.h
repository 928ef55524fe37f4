#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/fact_codes.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/ordered_bits.h"

namespace lode::tetra_mt {

struct ValueModels {
  NumberModel steps;
  BitModel is_above_last;
};

/// Codes values by where they are among a field's knots: a *place* in 16 bits, the knot at or below
/// and 256ths of the way to the next one, as a difference from that before; then which of the
/// numbers there it is.
template <typename Coder>
class ValueCoder {
 public:
  ValueCoder(Coder& coder, ValueModels& models, const ValueScale& scale, bool is_narrow,
             const std::string& what)
      : coder_(coder), models_(models), scale_(scale), is_narrow_(is_narrow), what_(what) {
    // Zeros count as -0, the smaller one.
    for (std::size_t k = 0; k < ValueScale::kKnots; ++k)
      knots_[k] = to_ordered(scale.knots()[k] == 0 ? -0.0 : scale.knots()[k], is_narrow);
  }

  /// Codes one more, in place. Returns its place.
  Result<std::uint32_t> code(double& value) {
    const std::uint64_t given = to_ordered(value, is_narrow_);
    std::uint32_t place = Coder::kReads ? 0 : place_of(given);
    const auto step = static_cast<std::int32_t>(place - last_);
    place = last_ + static_cast<std::uint32_t>(unfolded(models_.steps.code(coder_, folded(step))));
    const std::size_t knot = place / kParts;
    if (knot >= ValueScale::kKnots)
      return fail("{}: expected places of values below {}, got {}", what_,
                  ValueScale::kKnots * kParts, place);
    last_ = place;
    std::uint64_t ordered = knots_[knot];
    if (knot + 1 == ValueScale::kKnots) {
      ordered += coder_.bit(models_.is_above_last, given != ordered) ? 1 : 0;
    } else {
      const std::uint64_t begin = begin_of(knot, place % kParts);
      const std::uint64_t end = begin_of(knot, place % kParts + 1);
      if (begin >= end) return fail("{}: expected a place that values have, got {}", what_, place);
      ordered += begin + code_below(coder_, end - begin, given - ordered - begin);
    }
    if (Coder::kReads) LODE_CHECK(set(ordered, value));
    return place;
  }

 private:
  static constexpr std::uint32_t kParts = 256;

  /// Of the numbers between two knots, in units by which 2^40 of them are no more than 2^40.
  [[nodiscard]] std::uint64_t width_of(std::size_t knot) const {
    return knots_[knot + 1] > knots_[knot] ? knots_[knot + 1] - knots_[knot] : 0;
  }
  [[nodiscard]] static int unit_bits(std::uint64_t width) {
    return std::max(0, static_cast<int>(std::bit_width(width)) - 40);
  }
  /// The first number of a part, from the knot on.
  [[nodiscard]] std::uint64_t begin_of(std::size_t knot, std::uint32_t part) const {
    const std::uint64_t width = width_of(knot);
    if (width == 0) return 0;
    const int n_bits = unit_bits(width);
    const std::uint64_t n_units = ((width - 1) >> n_bits) + 1;
    return std::min(width, (part * n_units + kParts - 1) / kParts << n_bits);
  }
  [[nodiscard]] std::uint32_t place_of(std::uint64_t ordered) const {
    const auto above = std::ranges::upper_bound(knots_, ordered);
    const auto knot = static_cast<std::size_t>(above - knots_.begin()) - 1;
    const auto place = static_cast<std::uint32_t>(knot * kParts);
    if (knot + 1 == ValueScale::kKnots) return place;
    const std::uint64_t width = width_of(knot);
    const int n_bits = unit_bits(width);
    const std::uint64_t n_units = ((width - 1) >> n_bits) + 1;
    return place +
           static_cast<std::uint32_t>(((ordered - knots_[knot]) >> n_bits) * kParts / n_units);
  }
  Result<void> set(std::uint64_t ordered, double& value) const {
    value = from_ordered(ordered, is_narrow_);
    if (value >= scale_.knots().front() && value <= scale_.knots().back()) return {};
    return fail("{}: expected values from {} to {}, got {}", what_, scale_.knots().front(),
                scale_.knots().back(), value);
  }

  Coder& coder_;
  ValueModels& models_;
  const ValueScale& scale_;
  bool is_narrow_;
  const std::string& what_;
  std::array<std::uint64_t, ValueScale::kKnots> knots_;
  std::uint32_t last_ = ValueScale::kKnots * kParts / 2;
};

}  // namespace lode::tetra_mt
