#pragma once

#include <array>
#include <cstdint>

#include "lode/core/box.h"
#include "lode/core/vec.h"

namespace lode::tetra_mt {

/// Boxes round vertices of a domain in 22 bits, rounded outward: in steps of 2^-e of a power of two
/// that is at least the domain's largest width, with the largest e of 0 to 15 by which they reach
/// no more than 7 steps to either side of the vertex's. A grid's lines are lines of all finer ones:
/// boxes that are joined and rounded again do not grow with each time.
class BoxCodes {
 public:
  static constexpr int kExponentBits = 4;
  static constexpr int kAxisBits = 6;  ///< Steps below, then above.
  static constexpr int kBits = kExponentBits + 3 * kAxisBits;

  /// A box by the lines of a grid that it reaches to.
  struct Lines {
    std::int32_t exponent = 0;
    std::array<std::int32_t, 3> lower{};
    std::array<std::int32_t, 3> upper{};

    friend bool operator==(const Lines&, const Lines&) = default;
  };

  BoxCodes() = default;
  BoxCodes(const Vec3d& lower, const Vec3d& upper);

  /// `box`: in the domain, round the vertex.
  [[nodiscard]] std::uint32_t code(const Vec3d& vertex, const Box3d& box) const;
  [[nodiscard]] Box3d box(const Vec3d& vertex, std::uint32_t code) const;
  /// That box, without its vertex, which is in the domain.
  [[nodiscard]] Lines lines(const Vec3d& vertex, std::uint32_t code) const;
  [[nodiscard]] Box3d box(const Lines& lines) const;
  /// Of a box in the domain the lines of a grid that are next to it, about.
  [[nodiscard]] Lines lines_round(const Box3d& box, int exponent) const;

 private:
  static constexpr int kLastExponent = 15;
  static constexpr int kReachBits = kAxisBits / 2;
  static constexpr double kReach = 7;

  struct Steps {
    std::int32_t below;
    std::int32_t above;
  };
  [[nodiscard]] static int exponent_of(std::uint32_t code);
  [[nodiscard]] static Steps steps_of(std::uint32_t code, std::size_t axis);
  /// The place of a coordinate on the grid of an exponent.
  [[nodiscard]] double place(double x, std::size_t axis, int exponent) const;
  /// The coordinate of a line there.
  [[nodiscard]] double line(double place, std::size_t axis, int exponent) const;

  Vec3d lower_;
  double width_ = 0;  ///< 0 where there is but a point.
};

}  // namespace lode::tetra_mt
