#include "tests/oracles/fractal_terrain.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "lode/core/expects.h"

namespace lode::oracles {
namespace {

using Complex = std::complex<double>;

/// exp(2 pi i k / n) for k < n / 2.
std::vector<Complex> roots_of_unity(std::size_t n) {
  std::vector<Complex> roots(n / 2);
  for (std::size_t k = 0; k < roots.size(); ++k)
    roots[k] =
        std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
  return roots;
}

/// The inverse Fourier transform, not scaled, of n = 2^m values in place.
void transform(Complex* values, std::size_t n, const std::vector<Complex>& roots) {
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1;
    for (; (j & bit) != 0; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  for (std::size_t length = 2; length <= n; length *= 2) {
    const std::size_t stride = n / length;
    for (std::size_t first = 0; first < n; first += length)
      for (std::size_t k = 0; k < length / 2; ++k) {
        const Complex a = values[first + k];
        const Complex& w = roots[k * stride];
        const Complex& b = values[first + k + length / 2];
        const Complex turned(b.real() * w.real() - b.imag() * w.imag(),
                             b.real() * w.imag() + b.imag() * w.real());
        values[first + k] = a + turned;
        values[first + k + length / 2] = a - turned;
      }
  }
}

std::vector<Complex> random_spectrum(std::size_t side, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  std::vector<Complex> spectrum(side * side);
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const double radius = std::sqrt(-2 * std::log(uniform()));
      const double phase = 2 * std::numbers::pi * uniform();
      const auto kx = static_cast<double>(std::min(x, side - x));
      const auto ky = static_cast<double>(std::min(y, side - y));
      const double power = kx * kx + ky * ky;
      if (power > 0) spectrum[y * side + x] = std::polar(radius / power, phase);
    }
  return spectrum;
}

void transform_columns(std::vector<Complex>& values, std::size_t side,
                       const std::vector<Complex>& roots) {
  constexpr std::size_t kAtOnce = 4;
  std::vector<Complex> columns(kAtOnce * side);
  for (std::size_t first = 0; first < side; first += kAtOnce) {
    const std::size_t n = std::min(kAtOnce, side - first);
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t i = 0; i < n; ++i) columns[i * side + y] = values[y * side + first + i];
    for (std::size_t i = 0; i < n; ++i) transform(columns.data() + i * side, side, roots);
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t i = 0; i < n; ++i) values[y * side + first + i] = columns[i * side + y];
  }
}

}  // namespace

HeightGrid make_fractal_terrain(std::int32_t side, std::uint64_t seed) {
  const auto n = static_cast<std::size_t>(side);
  LODE_EXPECTS(side > 1 && (n & (n - 1)) == 0);
  std::vector<Complex> values = random_spectrum(n, seed);
  const std::vector<Complex> roots = roots_of_unity(n);
  for (std::size_t y = 0; y < n; ++y) transform(values.data() + y * n, n, roots);
  transform_columns(values, n, roots);
  const auto by_height = [](const Complex& a, const Complex& b) { return a.real() < b.real(); };
  const auto [lowest, highest] = std::minmax_element(values.begin(), values.end(), by_height);
  const double lower = lowest->real();
  const double scale = 65535 / (highest->real() - lower);
  HeightGrid grid = make_height_grid<std::uint16_t>(side, side);
  auto& samples = std::get<HeightGrid::Samples<std::uint16_t>>(grid.heights);
  for (std::size_t y = 0; y < n; ++y)
    for (std::size_t x = 0; x < n; ++x)
      samples[y * static_cast<std::size_t>(grid.stride) + x] =
          static_cast<std::uint16_t>(std::lround((values[y * n + x].real() - lower) * scale));
  return grid;
}

}  // namespace lode::oracles
