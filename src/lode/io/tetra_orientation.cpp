// Error bound and exact sums after Shewchuk, Adaptive precision floating-point arithmetic and fast
// robust geometric predicates, 1997.
#include "lode/io/tetra_orientation.h"

#include <cmath>
#include <cstddef>

namespace lode::io {
namespace {

/// A number as the exact sum of two, the second at most half a unit in the last place of the first.
struct TwoPart {
  double high = 0;
  double low = 0;
};

TwoPart exact_sum(double a, double b) {
  const double high = a + b;
  const double b_part = high - a;
  return {high, (a - (high - b_part)) + (b - b_part)};
}

TwoPart exact_product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}

/// An exact sum of numbers that do not overlap, in the order of their size.
class ExactSum {
 public:
  void add(double x) {
    std::size_t to = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      const TwoPart sum = exact_sum(x, parts_[i]);
      x = sum.high;
      if (sum.low != 0) parts_[to++] = sum.low;
    }
    if (x != 0) parts_[to++] = x;
    n_ = to;
  }
  void add_product(double x, double y, double z) {
    if (x == 0 || y == 0 || z == 0) return;
    const TwoPart xy = exact_product(x, y);
    for (const double part : {xy.low, xy.high}) {
      const TwoPart product = exact_product(part, z);
      add(product.low);
      add(product.high);
    }
  }
  [[nodiscard]] int sign() const {
    if (n_ == 0) return 0;
    return parts_[n_ - 1] > 0 ? 1 : -1;
  }

 private:
  /// 6 products of three numbers of two parts, of 4 parts each, are 192 parts.
  std::array<double, 193> parts_{};
  std::size_t n_ = 0;
};

/// b - a, exactly.
std::array<TwoPart, 3> exact_edge(const Vec3d& a, const Vec3d& b) {
  return {exact_sum(b[0], -a[0]), exact_sum(b[1], -a[1]), exact_sum(b[2], -a[2])};
}

int exact_orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const auto u = exact_edge(a, b);
  const auto v = exact_edge(a, c);
  const auto w = exact_edge(a, d);
  ExactSum sum;
  const auto add = [&](double x, const TwoPart& y, const TwoPart& z) {
    sum.add_product(x, y.low, z.low);
    sum.add_product(x, y.low, z.high);
    sum.add_product(x, y.high, z.low);
    sum.add_product(x, y.high, z.high);
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (const double x : {u[i].low, u[i].high}) {
      add(x, v[(i + 1) % 3], w[(i + 2) % 3]);
      add(-x, v[(i + 2) % 3], w[(i + 1) % 3]);
    }
  return sum.sign();
}

}  // namespace

int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  constexpr double kUnit = 0x1p-53;
  constexpr double kBound = (7 + 56 * kUnit) * kUnit;
  const Vec3d u = b - a;
  const Vec3d v = c - a;
  const Vec3d w = d - a;
  double volume = 0;
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double one = v[(i + 1) % 3] * w[(i + 2) % 3];
    const double other = v[(i + 2) % 3] * w[(i + 1) % 3];
    volume += u[i] * (one - other);
    size += std::abs(u[i]) * (std::abs(one) + std::abs(other));
  }
  if (std::abs(volume) > kBound * size) return volume > 0 ? 1 : -1;
  return exact_orientation(a, b, c, d);
}

}  // namespace lode::io
