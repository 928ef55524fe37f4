#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::tetra_mt::midpoint {

/// Position of a vertex in steps of Scales: 31 bits each;
using PositionCode = std::array<std::int32_t, 3>;
/// and with its value of one field, in steps of a Scale.
using Code = std::array<std::int32_t, 4>;

/// Steps of a power of two between two numbers, of which there are fewer than 2^31.
class Scale {
 public:
  Scale() = default;
  /// Finite, and so is what is between them.
  Scale(double low, double high);
  /// Of steps of 2^exponent, the `first`-th of them for a code of 0.
  Scale(int exponent, std::int64_t first);
  /// Whether such a scale is one: all its values are finite, and doubles hold them.
  [[nodiscard]] static bool is_valid(int exponent, std::int64_t first);

  /// The nearest step. Off by half a step, at most 2^-31 of what is between the ends, where these
  /// are more than 2^-21 of themselves apart; else by rounding of doubles.
  [[nodiscard]] std::int32_t code(double x) const;
  /// Exact: no rounding.
  [[nodiscard]] double value(std::int32_t code) const {
    return static_cast<double>(first_ + code) * step_;
  }
  [[nodiscard]] double step() const { return step_; }
  [[nodiscard]] int exponent() const;
  [[nodiscard]] std::int64_t first() const { return first_; }

  friend bool operator==(const Scale&, const Scale&) = default;

 private:
  double step_ = 1;
  std::int64_t first_ = 0;
};

/// Of what a code and its offset come to: an offset is no more than a step, so both are finite.
[[nodiscard]] Result<void> check_offset(double offset, const Scale& scale, const std::string& what);

/// What holds some values; of none, any.
[[nodiscard]] Scale scale_of(std::span<const double> values);

/// Of a mesh's positions.
class Scales {
 public:
  Scales() = default;
  explicit Scales(const TetraMesh& mesh);
  explicit Scales(const std::array<Scale, 3>& axes) : axes_(axes) {}

  [[nodiscard]] PositionCode code(const Vec3d& position) const {
    return {axes_[0].code(position[0]), axes_[1].code(position[1]), axes_[2].code(position[2])};
  }
  /// Of a PositionCode, or a Code.
  [[nodiscard]] Vec3d position(std::span<const std::int32_t> code) const {
    return {{axes_[0].value(code[0]), axes_[1].value(code[1]), axes_[2].value(code[2])}};
  }
  [[nodiscard]] const std::array<Scale, 3>& axes() const { return axes_; }

 private:
  std::array<Scale, 3> axes_;
};

/// Where an edge's new vertex lies, or which value it has: from its ends' two.
enum class Place : std::uint8_t { middle, first, second };
struct Placement {
  Place position = Place::middle;
  Place value = Place::middle;

  friend bool operator==(const Placement&, const Placement&) = default;
};

[[nodiscard]] constexpr Place turned(Place place) {
  return place == Place::middle ? place : place == Place::first ? Place::second : Place::first;
}

/// The new vertex, and what tells the ends from it: the second end's code less the first's. Whole
/// numbers go there and back without loss, halves are rounded down. Of other numbers than codes
/// something comes, modulo 2^32.
[[nodiscard]] std::int32_t merged(std::int32_t first, std::int32_t second, Place place);
[[nodiscard]] std::int32_t difference(std::int32_t first, std::int32_t second);
struct EndNumbers {
  std::int32_t first;
  std::int32_t second;
};
[[nodiscard]] EndNumbers parted(std::int32_t middle, std::int32_t difference, Place place);

[[nodiscard]] PositionCode merged(const PositionCode& first, const PositionCode& second,
                                  Place place);
[[nodiscard]] Code merged(const Code& first, const Code& second, Placement placement);
struct Ends {
  Code first;
  Code second;
};
[[nodiscard]] Ends parted(const Code& middle, const Code& difference, Placement placement);

}  // namespace lode::tetra_mt::midpoint
