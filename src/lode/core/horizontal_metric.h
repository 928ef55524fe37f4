#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "lode/core/ellipsoid.h"
#include "lode/core/place_map.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// What a way becomes in another CRS, in so many straight pieces of it.
struct Chords {
  double length = 0;
  bool is_even = true;  ///< Each about as long as one beside it: the map does not jump.
};

/// How distances are measured between places of a CRS: in its plane, or, where its coordinates are
/// longitudes and latitudes, on its ellipsoid.
struct HorizontalMetric {
  bool is_known = false;  ///< That there is a CRS; without one: in the plane, in unknown units.
  std::optional<Ellipsoid> ellipsoid{};  ///< Of what longitudes and latitudes are of.
  double angle_unit = 0;                 ///< Radians, with it.
  double length_unit = 1;                ///< Metres, of coordinates in the plane.
  std::string unit = "";                 ///< Of distances; empty: not known.
  std::string ellipsoid_name{};
  double prime_meridian = 0;  ///< Of the ellipsoid's: degrees east of Greenwich.
  std::string prime_meridian_name{};
  /// Distances are those in another CRS, whose metric this is, to which the map leads; null: in
  /// this one. Both are there, or none.
  std::shared_ptr<const HorizontalMetric> elsewhere{};
  std::shared_ptr<const PlaceMap> map{};

  /// By which distances are measured, and in whose unit.
  [[nodiscard]] const HorizontalMetric& measured() const { return elsewhere ? *elsewhere : *this; }
  /// Along the segment that is straight in the coordinates, where that is not here of what it
  /// becomes there; not a number where a place of it has none there, or the map jumps.
  [[nodiscard]] double distance(const Vec<double, 2>& from, const Vec<double, 2>& to) const {
    if (map) return mapped_distance(from, to);
    if (!ellipsoid) return length(to - from);
    return length_on(*ellipsoid, from * angle_unit, to * angle_unit);
  }
  /// Metres of a unit of distance; where the unit is not known it is taken for one.
  [[nodiscard]] double metres() const { return measured().ellipsoid ? 1 : measured().length_unit; }
  /// Metres of a unit of heights that nothing says: in a plane it is most likely that of x and y.
  [[nodiscard]] double assumed_height_unit() const { return ellipsoid ? 1 : length_unit; }

 private:
  [[nodiscard]] double mapped_distance(const Vec<double, 2>& from, const Vec<double, 2>& to) const;
  [[nodiscard]] Chords chords(const Vec<double, 2>& from, const Vec<double, 2>& to,
                              std::size_t n) const;
};

/// Refuses longitudes and latitudes that are none: latitudes beyond the poles, longitudes more than
/// a turn apart, but for a pixel. `lower` and `upper`: of a raster or segment, in its coordinates.
[[nodiscard]] Result<void> check_angles(const HorizontalMetric& metric, const Vec<double, 2>& lower,
                                        const Vec<double, 2>& upper);

}  // namespace lode
