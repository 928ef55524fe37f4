#pragma once

#include "lode/core/vec.h"

namespace lode {

/// An ellipsoid of revolution about the poles' axis.
struct Ellipsoid {
  double semi_major = 0;          ///< Metres.
  double inverse_flattening = 0;  ///< 0: a sphere.

  /// Metres, of the sphere that has the mean (2 a + b) / 3 of the half axes.
  [[nodiscard]] double mean_radius() const;
};

/// WGS 84.
inline constexpr Ellipsoid kWgs84Ellipsoid{6378137, 298.257223563};

/// Metres on the ellipsoid, at height 0, along the line from one place to another, longitudes and
/// latitudes in radians, that is straight in them: the integral of sqrt((M dlat)^2 + (N cos(lat)
/// dlon)^2), M and N the radii of curvature (Torge, "Geodesy", 3rd edition, section 4.1). By
/// Gauss's rule of five points in pieces of at most one degree, which errs by less than 1e-12 of it
/// between latitudes of 89 degrees. Not the geodesic, which is shorter and runs elsewhere.
[[nodiscard]] double length_on(const Ellipsoid& ellipsoid, const Vec<double, 2>& from,
                               const Vec<double, 2>& to);

}  // namespace lode
