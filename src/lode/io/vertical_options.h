#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lode::io {

/// What heights are above, as users say it: EPSG:N or WKT of a vertical CRS, or "ellipsoid", which
/// is that of the horizontal CRS, in metres. Empty: nothing.
struct VerticalOptions {
  std::string declared{};  ///< Of the heights in a file, whatever that says.
  std::string target{};    ///< To which they are transformed when they are read.

  [[nodiscard]] bool is_empty() const { return declared.empty() && target.empty(); }
};

/// What became of a file's heights.
struct VerticalOutcome {
  std::vector<std::string>
      notes{};                   ///< Where the file says something else than was taken, and so on.
  std::string transformation{};  ///< PROJ's name of what was done to heights; empty: nothing.
  std::optional<double> accuracy{};  ///< Of that, in metres, as PROJ states it.
};

/// The name of what heights are above, "ellipsoid" where it is that; empty where a CRS, as WKT or
/// empty, does not say.
[[nodiscard]] std::string vertical_name(const std::string& crs);

/// Whether a CRS, as WKT or empty, says that heights are depths, which grow downwards.
[[nodiscard]] bool has_depths(const std::string& crs);

/// A CRS as WKT, or empty, in a form that a GeoTIFF can have: of a projected one with heights above
/// its ellipsoid, for which there is none, a compound one whose vertical part is called
/// "ellipsoidal height", of an unknown datum; vertical_name() and transformations know it again.
[[nodiscard]] std::string to_geotiff_crs(const std::string& crs);

}  // namespace lode::io
