#include "lode/core/ellipsoid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lode {
namespace {

double flattening_of(const Ellipsoid& ellipsoid) {
  return ellipsoid.inverse_flattening == 0 ? 0 : 1 / ellipsoid.inverse_flattening;
}

}  // namespace

double Ellipsoid::mean_radius() const { return semi_major * (1 - flattening_of(*this) / 3); }

double length_on(const Ellipsoid& ellipsoid, const Vec<double, 2>& from, const Vec<double, 2>& to) {
  // Gauss and Legendre's abscissae and weights on [-1, 1], Abramowitz and Stegun, table 25.4.
  constexpr std::array<double, 5> kAt{-0.906179845938664, -0.538469310105683, 0, 0.538469310105683,
                                      0.906179845938664};
  constexpr std::array<double, 5> kWeight{0.236926885056189, 0.478628670499366, 0.568888888888889,
                                          0.478628670499366, 0.236926885056189};
  constexpr double kPiece = std::numbers::pi / 180;
  constexpr double kMostPieces = 1e6;
  const double flattening = flattening_of(ellipsoid);
  const double e2 = flattening * (2 - flattening);
  const double longitudes = to[0] - from[0];
  const double latitudes = to[1] - from[1];
  const double n = std::clamp(
      std::ceil(std::max(std::abs(longitudes), std::abs(latitudes)) / kPiece), 1.0, kMostPieces);
  double sum = 0;
  for (double piece = 0; piece < n; ++piece)
    for (std::size_t i = 0; i < kAt.size(); ++i) {
      const double latitude = from[1] + latitudes * (piece + 0.5 + kAt[i] / 2) / n;
      const double sine = std::sin(latitude);
      const double w2 = 1 - e2 * sine * sine;
      const double prime_vertical = ellipsoid.semi_major / std::sqrt(w2);
      const double meridian = prime_vertical * (1 - e2) / w2;
      sum += kWeight[i] *
             std::hypot(meridian * latitudes, prime_vertical * std::cos(latitude) * longitudes);
    }
  return sum / (2 * n);
}

}  // namespace lode
