#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// Values of a field in 12 bits: 256 of its values, from the smallest to the largest, with as many
/// between each two of them, and 16 steps from one to the next. So outliers do not cost the rest
/// its precision.
class ValueScale {
 public:
  static constexpr std::size_t kKnots = 256;
  static constexpr std::uint32_t kSteps = 16;
  static constexpr std::uint16_t kLargest = (kKnots - 1) * kSteps;  ///< Of codes;
  static constexpr std::uint16_t kLargestError = 0xFFF;             ///< of errors.
  using Knots = std::array<double, kKnots>;

  ValueScale() = default;
  /// Ascending and finite.
  explicit ValueScale(const Knots& knots);
  /// `values`: finite; none is like one of 0.
  [[nodiscard]] static ValueScale of(std::span<const double> values);

  [[nodiscard]] const Knots& knots() const { return knots_; }
  /// For codes up to kLargest: never less for a larger one.
  [[nodiscard]] double value(std::uint16_t code) const {
    const std::size_t knot = code / kSteps;
    const std::uint32_t step = code % kSteps;
    if (step == 0) return knots_[knot];
    return knots_[knot] + (knots_[knot + 1] - knots_[knot]) * (step / double{kSteps});
  }
  /// The largest code of a value up to `value`, which is none of below the smallest.
  [[nodiscard]] std::uint16_t code_below(double value) const;
  /// The smallest one of at least `value`, which is not above the largest.
  [[nodiscard]] std::uint16_t code_above(double value) const;

  /// Errors in 12 bits, rounded up by at most 1/128: of 32 octaves up to twice the range, or
  /// somewhat more. None that is not 0 is below the first.
  [[nodiscard]] float error(std::uint16_t code) const {
    if (code == 0) return 0;
    if (code == kLargestError) return std::numeric_limits<float>::infinity();
    const std::uint32_t octave = (code - 1U) >> 7;
    const double share = (128 + ((code - 1U) & 127)) / 128.0;
    return static_cast<float>(share * error_unit_ * static_cast<double>(1U << octave));
  }
  [[nodiscard]] std::uint16_t error_code(float error) const;

 private:
  Knots knots_{};
  double error_unit_ = 0x1p-31;  ///< A power of two.
};

/// A node's facts, of 12 bits each.
struct FactCodes {
  static constexpr int kBits = 12;

  std::uint16_t error = 0;
  std::uint16_t low = 0;
  std::uint16_t high = 0;

  friend bool operator==(const FactCodes&, const FactCodes&) = default;
};

/// Their range above knots()[0]; all rounded outward.
[[nodiscard]] StoredFacts to_facts(const FactCodes& codes, const ValueScale& scale);
/// `range_reference`: what the range of `facts` is above.
[[nodiscard]] FactCodes to_codes(const StoredFacts& facts, double range_reference,
                                 const ValueScale& scale);

}  // namespace lode::tetra_mt
