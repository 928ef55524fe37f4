#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace lode {

/// A fixed-size vector; indices run x, y, z.
template <typename T, std::size_t N>
struct Vec {
  std::array<T, N> v{};

  constexpr T& operator[](std::size_t i) { return v[i]; }
  constexpr const T& operator[](std::size_t i) const { return v[i]; }
  friend constexpr bool operator==(const Vec&, const Vec&) = default;
  friend constexpr auto operator<=>(const Vec&, const Vec&) = default;

  friend constexpr Vec operator+(Vec a, const Vec& b) {
    for (std::size_t i = 0; i < N; ++i) a.v[i] = static_cast<T>(a.v[i] + b.v[i]);
    return a;
  }
  friend constexpr Vec operator-(Vec a, const Vec& b) {
    for (std::size_t i = 0; i < N; ++i) a.v[i] = static_cast<T>(a.v[i] - b.v[i]);
    return a;
  }
  friend constexpr Vec operator*(Vec a, T s) {
    for (std::size_t i = 0; i < N; ++i) a.v[i] = static_cast<T>(a.v[i] * s);
    return a;
  }
  friend constexpr Vec operator*(T s, const Vec& a) { return a * s; }
};

using Vec3d = Vec<double, 3>;
using Vec3f = Vec<float, 3>;
/// Lattice coordinates of a sample or node; may be negative or beyond the data.
using Index3 = Vec<std::int32_t, 3>;

template <typename T, std::size_t N>
[[nodiscard]] constexpr T dot(const Vec<T, N>& a, const Vec<T, N>& b) {
  T sum{};
  for (std::size_t i = 0; i < N; ++i) sum = static_cast<T>(sum + a[i] * b[i]);
  return sum;
}

template <typename T>
[[nodiscard]] constexpr Vec<T, 3> cross(const Vec<T, 3>& a, const Vec<T, 3>& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

/// Exact.
[[nodiscard]] constexpr Vec3d widened(const Vec3f& p) {
  return {{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}};
}

template <typename T, std::size_t N>
[[nodiscard]] T length(const Vec<T, N>& a) {
  return std::sqrt(dot(a, a));
}

/// a scaled to length 1; the zero vector stays zero.
template <typename T, std::size_t N>
[[nodiscard]] Vec<T, N> normalized(const Vec<T, N>& a) {
  const T n = length(a);
  return n > T(0) ? a * (T(1) / n) : a;
}

/// Row-major 3 × 3 matrix.
struct Mat3 {
  std::array<Vec3d, 3> rows{};

  [[nodiscard]] static constexpr Mat3 identity() {
    return {{Vec3d{{1, 0, 0}}, Vec3d{{0, 1, 0}}, Vec3d{{0, 0, 1}}}};
  }
  friend constexpr bool operator==(const Mat3&, const Mat3&) = default;
  friend constexpr Vec3d operator*(const Mat3& m, const Vec3d& a) {
    return {{dot(m.rows[0], a), dot(m.rows[1], a), dot(m.rows[2], a)}};
  }
  [[nodiscard]] constexpr Vec3d column(std::size_t i) const {
    return {{rows[0][i], rows[1][i], rows[2][i]}};
  }
};

[[nodiscard]] constexpr double determinant(const Mat3& m) {
  return dot(m.rows[0], cross(m.rows[1], m.rows[2]));
}

/// The inverse transpose times the determinant (the cofactor matrix): maps gradients and area
/// normals from index space to world space, up to the determinant's sign and scale.
[[nodiscard]] constexpr Mat3 cofactors(const Mat3& m) {
  return {{cross(m.rows[1], m.rows[2]), cross(m.rows[2], m.rows[0]), cross(m.rows[0], m.rows[1])}};
}

}  // namespace lode
