#include "lode/models/tetra_mt/box_codes.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace lode::tetra_mt {
namespace {

/// A line of a grid; wherever files lead, one that is not far from the domain's.
std::int32_t clamped_line(double place) {
  constexpr double kFar = 0x1p20;
  if (!(place > -kFar)) return static_cast<std::int32_t>(-kFar);  // also what is no number
  return static_cast<std::int32_t>(std::min(place, kFar));
}

}  // namespace

BoxCodes::BoxCodes(const Vec3d& lower, const Vec3d& upper) : lower_(lower) {
  double width = 0;
  for (std::size_t i = 0; i < 3; ++i) width = std::max(width, upper[i] - lower[i]);
  if (!(width > 0) || !std::isfinite(width)) return;
  int exponent = 0;
  std::frexp(width, &exponent);
  // Lines of the finest grid are exact where the domain is not very far away.
  const double finest = std::ldexp(1.0, exponent - kLastExponent);
  if (finest == 0) return;
  width_ = std::ldexp(1.0, exponent);
  for (std::size_t i = 0; i < 3; ++i) lower_[i] = std::floor(lower[i] / finest) * finest;
}

double BoxCodes::place(double x, std::size_t axis, int exponent) const {
  return std::ldexp((x - lower_[axis]) / width_, exponent);
}

double BoxCodes::line(double place, std::size_t axis, int exponent) const {
  return lower_[axis] + place * std::ldexp(width_, -exponent);
}

int BoxCodes::exponent_of(std::uint32_t code) {
  return static_cast<int>(code & ((1U << kExponentBits) - 1));
}

BoxCodes::Steps BoxCodes::steps_of(std::uint32_t code, std::size_t axis) {
  constexpr std::uint32_t kMask = (1U << kReachBits) - 1;
  const std::uint32_t steps = code >> (kExponentBits + kAxisBits * static_cast<int>(axis));
  return {static_cast<std::int32_t>(steps & kMask),
          static_cast<std::int32_t>(steps >> kReachBits & kMask)};
}

std::uint32_t BoxCodes::code(const Vec3d& vertex, const Box3d& box) const {
  if (width_ == 0) return 0;
  const auto try_exponent = [&](int exponent) -> std::optional<std::uint32_t> {
    auto bits = static_cast<std::uint32_t>(exponent);
    int at = kExponentBits;
    for (std::size_t i = 0; i < 3; ++i) {
      const double middle = std::floor(place(vertex[i], i, exponent));
      // Where a place was rounded to a line, the coordinate may be beyond it.
      double first = std::floor(place(box.lower[i], i, exponent));
      if (line(first, i, exponent) > box.lower[i]) --first;
      double last = std::ceil(place(box.upper[i], i, exponent));
      if (line(last, i, exponent) < box.upper[i]) ++last;
      const double below = middle - first;
      const double above = last - middle;
      if (std::max(below, above) > kReach) return std::nullopt;
      for (const double steps : {below, above}) {
        bits |= static_cast<std::uint32_t>(std::max(steps, 0.0)) << at;
        at += kReachBits;
      }
    }
    return bits;
  };
  for (int exponent = kLastExponent; exponent > 0; --exponent)
    if (const auto bits = try_exponent(exponent)) return *bits;
  return try_exponent(0).value_or((1U << kBits) - (1U << kExponentBits));
}

Box3d BoxCodes::box(const Vec3d& vertex, std::uint32_t code) const {
  if (width_ == 0) return {vertex, vertex};
  const int exponent = exponent_of(code);
  Box3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    const double middle = std::floor(place(vertex[i], i, exponent));
    const Steps steps = steps_of(code, i);
    result.lower[i] = line(middle - steps.below, i, exponent);
    result.upper[i] = line(middle + steps.above, i, exponent);
  }
  return result;
}

BoxCodes::Lines BoxCodes::lines(const Vec3d& vertex, std::uint32_t code) const {
  if (width_ == 0) return {};
  Lines result{.exponent = exponent_of(code)};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto middle = clamped_line(std::floor(place(vertex[i], i, result.exponent)));
    const Steps steps = steps_of(code, i);
    result.lower[i] = middle - steps.below;
    result.upper[i] = middle + steps.above;
  }
  return result;
}

Box3d BoxCodes::box(const Lines& lines) const {
  Box3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    result.lower[i] = line(lines.lower[i], i, lines.exponent);
    result.upper[i] = line(lines.upper[i], i, lines.exponent);
  }
  return result;
}

BoxCodes::Lines BoxCodes::lines_round(const Box3d& box, int exponent) const {
  Lines result{.exponent = exponent};
  if (width_ == 0) return result;
  for (std::size_t i = 0; i < 3; ++i) {
    result.lower[i] = clamped_line(std::floor(place(box.lower[i], i, exponent)));
    result.upper[i] = clamped_line(std::ceil(place(box.upper[i], i, exponent)));
  }
  return result;
}

}  // namespace lode::tetra_mt
