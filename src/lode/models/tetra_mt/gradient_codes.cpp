#include "lode/models/tetra_mt/gradient_codes.h"

#include <algorithm>
#include <cmath>

namespace lode::tetra_mt {
namespace {

constexpr std::uint32_t kMask = (1U << kGradientBits) - 1;
constexpr double kSteps = kGradientSteps;
constexpr int kLowest = -63;  ///< Octave.

/// Quarters of an octave are linear: exact on all machines.
double length_of_code(std::uint32_t code) {
  const int quarters = static_cast<int>(code) - 1;
  return std::ldexp(1 + 0.25 * (quarters % 4), kLowest + quarters / 4);
}

double sign_of(double x) { return x < 0 ? -1 : 1; }

std::uint32_t to_step(double x) {
  return static_cast<std::uint32_t>(std::clamp(std::round((x + 1) / 2 * kSteps), 0.0, kSteps));
}

}  // namespace

std::uint32_t gradient_code(const Vec3f& gradient) {
  const double x = static_cast<double>(gradient[0]);
  const double y = static_cast<double>(gradient[1]);
  const double z = static_cast<double>(gradient[2]);
  const double size = std::abs(x) + std::abs(y) + std::abs(z);
  if (!(size > 0) || !std::isfinite(size)) return 0;
  double u = x / size;
  double v = y / size;
  if (z < 0) {
    const double folded = (1 - std::abs(v)) * sign_of(u);
    v = (1 - std::abs(u)) * sign_of(v);
    u = folded;
  }
  const double length = std::sqrt(x * x + y * y + z * z);
  std::uint32_t code = 1;
  while (code < UINT8_MAX && length_of_code(code + 1) <= length) ++code;
  return to_step(u) | to_step(v) << kGradientBits | code << (2 * kGradientBits);
}

Vec3f gradient_of(std::uint32_t code) {
  const std::uint32_t length_code = code >> (2 * kGradientBits);
  if (length_code == 0) return {};
  double u = (code & kMask) / kSteps * 2 - 1;
  double v = (code >> kGradientBits & kMask) / kSteps * 2 - 1;
  const double z = 1 - std::abs(u) - std::abs(v);
  if (z < 0) {
    const double folded = (1 - std::abs(v)) * sign_of(u);
    v = (1 - std::abs(u)) * sign_of(v);
    u = folded;
  }
  const double scale = length_of_code(length_code) / std::sqrt(u * u + v * v + z * z);
  return {{static_cast<float>(u * scale), static_cast<float>(v * scale),
           static_cast<float>(z * scale)}};
}

}  // namespace lode::tetra_mt
