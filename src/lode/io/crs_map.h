#pragma once

#include <memory>
#include <string>

#include "lode/core/horizontal_metric.h"
#include "lode/core/place_map.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

/// A CRS that places of another one are put in.
struct TargetCrs {
  std::string name;
  /// As WKT, of x and y, and of what heights are above in the other one, where that says it.
  std::string crs;
  HorizontalMetric metric;  ///< Of it.
  std::shared_ptr<const PlaceMap> map;
  /// PROJ knows no way between the datums, with the grids that are there, and takes them for one:
  /// places may be off by hundreds of metres.
  bool is_guess = false;
};

/// Fails on what is no geographic or projected CRS, EPSG:N or WKT, and on those that have heights:
/// these are transformed when they are read (VerticalOptions).
[[nodiscard]] Result<void> check_target_crs(const std::string& target);

/// Places of a CRS, as WKT, in another one, through PROJ, x and y alone. Longitudes come within
/// half a turn of those of the places themselves, or, where these are none, of that of `middle`.
/// Fails as check_target_crs() does, where the first CRS is not known, where there is no way
/// from it, and where heights are above its ellipsoid and the other one has another.
[[nodiscard]] Result<TargetCrs> open_target_crs(const std::string& source,
                                                const std::string& target,
                                                const Vec<double, 2>& middle);

/// A CRS that places are given in, for terrain of another one.
struct SourceCrs {
  std::string name;
  std::shared_ptr<const PlaceMap> map;
  bool is_guess = false;  ///< As TargetCrs.
};

/// Places of a CRS, EPSG:N or WKT, in that of `target`, as WKT, whose heights do not matter.
/// Longitudes there come within half a turn of that of `middle`, a place there. Fails where
/// check_target_crs() does of the source, where the target is not known, and where there is no way
/// to it.
[[nodiscard]] Result<SourceCrs> open_source_crs(const std::string& source,
                                                const std::string& target,
                                                const Vec<double, 2>& middle);

}  // namespace lode::io
