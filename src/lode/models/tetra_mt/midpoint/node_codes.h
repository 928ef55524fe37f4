#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/refine/model.h"

namespace lode::tetra_mt::midpoint {

/// The radius of a node's ball, rounded up, in 12 bits: steps of 0.3 %, over 16 octaves below the
/// largest; the last code is infinite.
class RadiusCodes {
 public:
  RadiusCodes() : RadiusCodes(0) {}
  explicit RadiusCodes(double largest);

  /// At least as large; expects what is no larger than the largest.
  [[nodiscard]] std::uint32_t code(double radius) const;
  [[nodiscard]] double radius(std::uint32_t code) const { return radii_[code]; }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  double largest_;
  std::array<double, 4096> radii_{};
};

/// What is known of a node in 32 bits, all rounded outward: of a field its error in 8 (steps of 4.5
/// %, over 16 octaves below the largest) and the ends of its range in 6 each (64 values of the
/// field, with as many between each two); and RadiusCodes' of its ball. Larger codes stand for
/// larger numbers, so that codes can be joined.
class NodeCodes {
 public:
  struct Parts {
    std::uint32_t error = 0;
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    std::uint32_t radius = 0;
  };
  static constexpr std::size_t kKnots = 64;

  using Knots = std::array<double, kKnots>;

  NodeCodes() : NodeCodes(Knots{}, 0) {}
  /// `values`: finite; `largest_error`: of all nodes.
  NodeCodes(std::span<const double> values, double largest_error);
  /// `knots`: ascending.
  NodeCodes(const Knots& knots, double largest_error);

  /// At least as large; expects what is no larger than the largest.
  [[nodiscard]] std::uint32_t error_code(double error) const;
  /// The last knot up to a value, and the first of at least that.
  [[nodiscard]] std::uint32_t low_code(double value) const;
  [[nodiscard]] std::uint32_t high_code(double value) const;

  /// Whether the low is no higher than the high: where knots are equal, its code may be.
  [[nodiscard]] bool has_range(const Parts& parts) const {
    return knots_[parts.low] <= knots_[parts.high];
  }
  [[nodiscard]] float error(std::uint32_t code) const { return errors_[code]; }
  /// The range above the first knot.
  [[nodiscard]] StoredFacts facts(const Parts& parts) const;
  [[nodiscard]] const Knots& knots() const { return knots_; }
  [[nodiscard]] double largest_error() const { return largest_error_; }

  [[nodiscard]] static std::uint32_t word(const Parts& parts) {
    return parts.error | parts.low << 8 | parts.high << 14 | parts.radius << kRadiusAt;
  }
  [[nodiscard]] static Parts parts(std::uint32_t word) {
    return {word & 0xFF, word >> 8 & 0x3F, word >> 14 & 0x3F, word >> kRadiusAt};
  }
  /// What is known of a field, with the ball that another word has.
  [[nodiscard]] static std::uint32_t with_ball_of(std::uint32_t field, std::uint32_t other) {
    return (field & kOfField) | (other & ~kOfField);
  }
  [[nodiscard]] static std::uint32_t without_ball(std::uint32_t word) { return word & kOfField; }

 private:
  static constexpr int kRadiusAt = 20;
  static constexpr std::uint32_t kOfField = (1U << kRadiusAt) - 1;

  double largest_error_;
  std::array<float, 256> errors_{};  ///< By code.
  Knots knots_{};
};

}  // namespace lode::tetra_mt::midpoint
