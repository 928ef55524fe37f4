#include "lode/io/crs_metric.h"

#include <new>
#include <span>

#include "lode/core/out_of_memory.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/vector_input.h"

namespace lode::io {
namespace {

/// Keeps GDAL's messages from stderr.
class QuietGdal {
 public:
  explicit QuietGdal(const GdalLibrary& gdal) : gdal_(gdal) {
    gdal_.push_error_handler(gdal_.quiet_handler);
  }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
  ~QuietGdal() { gdal_.pop_error_handler(); }

 private:
  const GdalLibrary& gdal_;
};

}  // namespace

Result<HorizontalMetric> read_metric(const std::string& crs) try {
  if (crs.empty()) return HorizontalMetric{};
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  LODE_TRY(const GdalCrs read, GdalCrs::of(crs));
  HorizontalMetric metric{.is_known = true};
  char* unit = nullptr;
  if (gdal->is_geographic(read.handle()) != 0) {
    metric.angle_unit = gdal->angular_units(read.handle(), nullptr);
    metric.ellipsoid = Ellipsoid{gdal->semi_major(read.handle(), nullptr),
                                 gdal->inverse_flattening(read.handle(), nullptr)};
    const char* name = gdal->attribute(read.handle(), "SPHEROID", 0);
    if (name == nullptr) name = gdal->attribute(read.handle(), "ELLIPSOID", 0);
    metric.ellipsoid_name = name == nullptr ? "unnamed" : without_controls(name);
    char* meridian = nullptr;
    metric.prime_meridian = gdal->prime_meridian(read.handle(), &meridian);
    metric.prime_meridian_name = meridian == nullptr ? "unnamed" : without_controls(meridian);
    metric.unit = "metre";
    if (!(metric.angle_unit > 0 && metric.ellipsoid->semi_major > 0 &&
          (metric.ellipsoid->inverse_flattening == 0 || metric.ellipsoid->inverse_flattening > 1)))
      return fail("expected a CRS with an ellipsoid and a unit of angles, got {}", crs);
    return metric;
  }
  metric.length_unit = gdal->linear_units(read.handle(), &unit);
  metric.unit = unit == nullptr ? "" : without_controls(unit);
  if (!(metric.length_unit > 0)) return fail("expected a CRS with a unit of length, got {}", crs);
  return metric;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the CRS");
}

Result<Vec<double, 2>> to_wgs84(const std::string& crs, Vec<double, 2> place) try {
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  const QuietGdal quiet(*gdal);
  LODE_TRY(const PlaceTransform way,
           PlaceTransform::make("the place", crs, "EPSG:4326", "degrees of WGS 84"));
  LODE_CHECK(way.apply(std::span(&place, 1)));
  return place;
} catch (const std::bad_alloc&) {
  return out_of_memory("transform a place");
}

}  // namespace lode::io
