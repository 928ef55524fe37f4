#pragma once

#include <ogr_srs_api.h>

#include <string>
#include <utility>

#include "lode/io/gdal_library.h"

namespace lode::io {

/// A CRS as GDAL has it, whose messages are kept from stderr meanwhile. Coordinates come as x, y:
/// easting before northing, longitude before latitude, as in rasters.
class GdalCrs {
 public:
  /// Of WKT, EPSG:N, or, compound, EPSG:N+M, whose second code is of a vertical CRS. Fails on other
  /// text.
  [[nodiscard]] static Result<GdalCrs> of(const std::string& text);

  GdalCrs(const GdalCrs&) = delete;
  GdalCrs& operator=(const GdalCrs&) = delete;
  GdalCrs(GdalCrs&& other) noexcept
      : gdal_(std::exchange(other.gdal_, nullptr)), handle_(other.handle_) {}
  GdalCrs& operator=(GdalCrs&&) = delete;
  ~GdalCrs();

  [[nodiscard]] OGRSpatialReferenceH handle() const { return handle_; }
  /// Leaves x and y alone: with heights in it GDAL may choose another transformation of these.
  void strip_heights() const;

 private:
  GdalCrs(const GdalLibrary* gdal, OGRSpatialReferenceH handle) : gdal_(gdal), handle_(handle) {}

  const GdalLibrary* gdal_;
  OGRSpatialReferenceH handle_;
};

/// A CRS, given as EPSG:N, EPSG:N+M or as WKT, as WKT. Fails where GDAL does not know it.
[[nodiscard]] Result<std::string> to_wkt(const std::string& crs);

/// The same of a CRS that is to be one of x and y, perhaps with heights: fails on vertical and
/// geocentric ones, too.
[[nodiscard]] Result<std::string> to_horizontal_wkt(const std::string& crs);

/// Fails where a file has another CRS, in WKT, than the one that it is said to have.
[[nodiscard]] Result<void> check_same_crs(const std::string& path, const std::string& own,
                                          const std::string& stated);

}  // namespace lode::io
