#include "lode/models/tetra_mt/midpoint/codes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lode::tetra_mt::midpoint {
namespace {

constexpr std::int32_t kLast = std::numeric_limits<std::int32_t>::max();
constexpr int kFraction = 52;  ///< Bits of a double's.
constexpr int kLeast = -1074;  ///< The exponent of the smallest one.
constexpr int kMostExponent = 1023;
constexpr int kCodeBits = 30;  ///< Steps are no larger than 2^-30 of what is between the ends.

std::int32_t less(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

Place place_of(Placement placement, std::size_t axis) {
  return axis < 3 ? placement.position : placement.value;
}

}  // namespace

Scale::Scale(double low, double high) {
  const double largest = std::max(std::abs(low), std::abs(high));
  int exponent = largest > 0 ? std::ilogb(largest) - kFraction : 0;
  if (high > low) exponent = std::max(exponent, std::ilogb(high - low) - kCodeBits);
  exponent = std::max(exponent, kLeast);
  step_ = std::ldexp(1.0, exponent);
  first_ = static_cast<std::int64_t>(std::floor(low / step_));
  if (std::llround(high / step_) - first_ <= kLast) return;
  step_ *= 2;
  first_ = static_cast<std::int64_t>(std::floor(low / step_));
}

Scale::Scale(int exponent, std::int64_t first) : step_(std::ldexp(1.0, exponent)), first_(first) {}

bool Scale::is_valid(int exponent, std::int64_t first) {
  constexpr std::int64_t kMost = std::int64_t{1} << (kFraction + 1);
  if (exponent < kLeast || exponent > kMostExponent || first < -kMost || first > kMost)
    return false;
  const Scale scale(exponent, first);
  return std::isfinite(scale.value(0)) && std::isfinite(scale.value(kLast));
}

int Scale::exponent() const { return std::ilogb(step_); }

std::int32_t Scale::code(double x) const {
  const std::int64_t steps = std::llround(x / step_) - first_;
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(steps, 0, kLast));
}

Scale scale_of(std::span<const double> values) {
  if (values.empty()) return {};
  const auto [low, high] = std::ranges::minmax(values);
  return {low, high};
}

Scales::Scales(const TetraMesh& mesh) {
  std::vector<double> numbers(mesh.positions.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t v = 0; v < numbers.size(); ++v) numbers[v] = mesh.positions[v][axis];
    axes_[axis] = scale_of(numbers);
  }
}

std::int32_t difference(std::int32_t first, std::int32_t second) { return less(second, first); }

std::int32_t merged(std::int32_t first, std::int32_t second, Place place) {
  switch (place) {
    case Place::first: return first;
    case Place::second: return second;
    case Place::middle: break;
  }
  return less(first, -(less(second, first) >> 1));
}

EndNumbers parted(std::int32_t middle, std::int32_t difference, Place place) {
  const std::int32_t first = place == Place::first    ? middle
                             : place == Place::second ? less(middle, difference)
                                                      : less(middle, difference >> 1);
  return {first, less(first, less(0, difference))};
}

PositionCode merged(const PositionCode& first, const PositionCode& second, Place place) {
  PositionCode made;
  for (std::size_t i = 0; i < made.size(); ++i) made[i] = merged(first[i], second[i], place);
  return made;
}

Code merged(const Code& first, const Code& second, Placement placement) {
  Code made;
  for (std::size_t i = 0; i < made.size(); ++i)
    made[i] = merged(first[i], second[i], place_of(placement, i));
  return made;
}

Ends parted(const Code& middle, const Code& difference, Placement placement) {
  Ends ends;
  for (std::size_t i = 0; i < middle.size(); ++i) {
    const EndNumbers both = parted(middle[i], difference[i], place_of(placement, i));
    ends.first[i] = both.first;
    ends.second[i] = both.second;
  }
  return ends;
}

Result<void> check_offset(double offset, const Scale& scale, const std::string& what) {
  if (std::abs(offset) <= scale.step()) return {};
  return fail("{}: expected an offset of at most a step, {}, got {}", what, scale.step(), offset);
}

}  // namespace lode::tetra_mt::midpoint
