#include "lode/io/gdal_crs.h"

#include "lode/io/text.h"

namespace lode::io {

Result<GdalCrs> GdalCrs::of(const std::string& wkt) {
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  gdal->push_error_handler(gdal->quiet_handler);
  GdalCrs crs(gdal, gdal->new_crs(nullptr));
  std::string text = wkt;
  char* at = text.data();
  if (crs.handle_ == nullptr || gdal->import_wkt(crs.handle_, &at) != OGRERR_NONE)
    return fail("expected a CRS in WKT, got {}", quoted(wkt));
  gdal->set_axis_order(crs.handle_, OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

GdalCrs::~GdalCrs() {
  if (gdal_ == nullptr) return;
  gdal_->destroy_crs(handle_);
  gdal_->pop_error_handler();
}

}  // namespace lode::io
