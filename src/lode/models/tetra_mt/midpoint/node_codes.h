#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/refine/model.h"

namespace lode::tetra_mt::midpoint {

/// What is known of a node in 32 bits, all rounded outward: its error in 8 (steps of 4.5 %, over 16
/// octaves below the largest), the ends of its range in 6 each (64 values of the field, with as
/// many between each two), and the radius of its ball in 12 (steps of 0.3 %, over 16 octaves below
/// the largest; the last code is infinite). Larger codes stand for larger numbers, so that codes
/// can be joined.
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

  NodeCodes() : NodeCodes(Knots{}, 0, 0) {}
  /// `values`: finite; `largest_error`: of all nodes.
  NodeCodes(std::span<const double> values, double largest_error, double largest_radius);
  /// `knots`: ascending.
  NodeCodes(const Knots& knots, double largest_error, double largest_radius);

  /// At least as large; expects what is no larger than the largest.
  [[nodiscard]] std::uint32_t error_code(double error) const;
  [[nodiscard]] std::uint32_t radius_code(double radius) const;
  /// The last knot up to a value, and the first of at least that.
  [[nodiscard]] std::uint32_t low_code(double value) const;
  [[nodiscard]] std::uint32_t high_code(double value) const;

  /// Whether the low is no higher than the high: where knots are equal, its code may be.
  [[nodiscard]] bool has_range(const Parts& parts) const {
    return knots_[parts.low] <= knots_[parts.high];
  }
  [[nodiscard]] double radius(std::uint32_t code) const { return radii_[code]; }
  [[nodiscard]] float error(std::uint32_t code) const { return errors_[code]; }
  /// The range above the first knot.
  [[nodiscard]] StoredFacts facts(const Parts& parts) const;
  [[nodiscard]] const Knots& knots() const { return knots_; }
  [[nodiscard]] double largest_error() const { return largest_error_; }
  [[nodiscard]] double largest_radius() const { return largest_radius_; }

  [[nodiscard]] static std::uint32_t word(const Parts& parts) {
    return parts.error | parts.low << 8 | parts.high << 14 | parts.radius << 20;
  }
  [[nodiscard]] static Parts parts(std::uint32_t word) {
    return {word & 0xFF, word >> 8 & 0x3F, word >> 14 & 0x3F, word >> 20};
  }

 private:
  double largest_error_;
  double largest_radius_;
  std::array<float, 256> errors_{};  ///< By code.
  Knots knots_{};
  std::array<double, 4096> radii_{};
};

}  // namespace lode::tetra_mt::midpoint
