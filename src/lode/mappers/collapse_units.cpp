#include "lode/mappers/collapse_units.h"

#include <cmath>

#include "lode/mappers/collapse_mesh.h"

namespace lode::simplification {

UnitEdges::UnitEdges(Surface& surface) : surface_(surface) {
  const double edge = std::sqrt(mean_area(surface));
  if (edge > 0 && std::isfinite(edge)) exponent_ = -std::ilogb(edge);
  scale(exponent_);
}

UnitEdges::~UnitEdges() { scale(-exponent_); }

double UnitEdges::to_units(double length) const { return std::ldexp(length, exponent_); }

double UnitEdges::from_units(double length) const { return std::ldexp(length, -exponent_); }

void UnitEdges::scale(int exponent) {
  if (exponent == 0) return;
  constexpr int kMost = 126;  // 2^126 and its inverse are normal numbers
  for (; exponent > kMost; exponent -= kMost) multiply(std::ldexp(1.0F, kMost));
  for (; exponent < -kMost; exponent += kMost) multiply(std::ldexp(1.0F, -kMost));
  multiply(std::ldexp(1.0F, exponent));
}

void UnitEdges::multiply(float factor) {
  for (Vec3f& p : surface_.positions) p = p * factor;
}

}  // namespace lode::simplification
