#include "lode/models/tetra_mt/world_codes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::tetra_mt {
namespace {

constexpr int kOctaveSteps = 8;
constexpr int kWorldOctaves = 32;

/// 2^e, e from -90 to 126, is above the length, as far as that goes.
double unit_of(double diagonal) {
  const int exponent = diagonal > 0 && std::isfinite(diagonal) ? std::ilogb(diagonal) + 1 : 0;
  return std::ldexp(1.0, std::clamp(exponent, -90, 126) - (kWorldOctaves - 1));
}

}  // namespace

WorldCodes::WorldCodes(const Vec3d& lower, const Vec3d& upper)
    : unit_(unit_of(length(upper - lower))) {}

float WorldCodes::error(std::uint8_t code) const {
  if (code == 0) return 0;
  const int octave = (code - 1) / kOctaveSteps;
  if (code == kInfinite || octave >= kWorldOctaves) return std::numeric_limits<float>::infinity();
  const double share = static_cast<double>(kOctaveSteps + (code - 1) % kOctaveSteps) / kOctaveSteps;
  return static_cast<float>(std::ldexp(share * unit_, octave));
}

std::uint8_t WorldCodes::code(float error) const {
  if (!(error > 0)) return 0;
  std::uint8_t low = 1;
  for (std::uint8_t high = kInfinite; low < high;) {
    const auto middle = static_cast<std::uint8_t>((low + high) / 2);
    if (this->error(middle) >= error)
      high = middle;
    else
      low = static_cast<std::uint8_t>(middle + 1);
  }
  return low;
}

}  // namespace lode::tetra_mt
