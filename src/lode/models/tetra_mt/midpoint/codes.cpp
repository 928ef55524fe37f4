#include "lode/models/tetra_mt/midpoint/codes.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

Scales::Scales(const TetraMesh& mesh) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = 0;
    double high = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const double x = mesh.positions[v][axis];
      low = v == 0 ? x : std::min(low, x);
      high = v == 0 ? x : std::max(high, x);
    }
    axes_[axis] = Scale(low, high);
  }
  const std::vector<double>& values = mesh.fields[0].values;
  if (values.empty()) return;
  const auto [low, high] = std::ranges::minmax(values);
  axes_[3] = Scale(low, high);
}

Code merged(const Code& first, const Code& second, Placement placement) {
  Code made = first;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::int32_t way = less(second[i], first[i]);
    switch (place_of(placement, i)) {
      case Place::middle: made[i] = less(first[i], -(way >> 1)); break;
      case Place::first: made[i] = first[i]; break;
      case Place::second: made[i] = second[i]; break;
    }
  }
  return made;
}

Code difference(const Code& first, const Code& second) {
  Code way;
  for (std::size_t i = 0; i < 4; ++i) way[i] = less(second[i], first[i]);
  return way;
}

Ends parted(const Code& middle, const Code& difference, Placement placement) {
  Ends ends{middle, middle};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::int32_t way = difference[i];
    switch (place_of(placement, i)) {
      case Place::middle: ends.first[i] = less(middle[i], way >> 1); break;
      case Place::first: ends.first[i] = middle[i]; break;
      case Place::second: ends.first[i] = less(middle[i], way); break;
    }
    ends.second[i] = less(ends.first[i], less(0, way));
  }
  return ends;
}

Result<void> check_offset(double offset, const Scale& scale, const std::string& what) {
  if (std::abs(offset) <= scale.step()) return {};
  return fail("{}: expected an offset of at most a step, {}, got {}", what, scale.step(), offset);
}

}  // namespace lode::tetra_mt::midpoint
