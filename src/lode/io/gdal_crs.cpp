#include "lode/io/gdal_crs.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

#include "lode/io/gdal_raster.h"
#include "lode/io/text.h"

namespace lode::io {

namespace {

/// Of EPSG:N; none of other text.
std::optional<int> epsg_code(const std::string& text) {
  constexpr std::string_view kPrefix = "epsg:";
  if (!to_lower(text).starts_with(kPrefix)) return std::nullopt;
  const auto code = to_int64(std::string_view(text).substr(kPrefix.size()));
  constexpr std::int64_t kMostCode = 1 << 20;
  return static_cast<int>(std::clamp<std::int64_t>(code.value_or(0), 0, kMostCode));
}

}  // namespace

Result<GdalCrs> GdalCrs::of(const std::string& text) {
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  gdal->push_error_handler(gdal->quiet_handler);
  GdalCrs crs(gdal, gdal->new_crs(nullptr));
  const auto import = [&] {
    if (const auto code = epsg_code(text)) return gdal->import_epsg(crs.handle_, *code);
    std::string wkt = text;
    char* at = wkt.data();
    return gdal->import_wkt(crs.handle_, &at);
  };
  if (crs.handle_ == nullptr || import() != OGRERR_NONE)
    return fail("expected a CRS as WKT or EPSG:N, got {}", quoted(text));
  gdal->set_axis_order(crs.handle_, OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

GdalCrs::~GdalCrs() {
  if (gdal_ == nullptr) return;
  gdal_->destroy_crs(handle_);
  gdal_->pop_error_handler();
}

Result<std::string> to_wkt(const std::string& crs) {
  LODE_TRY(const GdalCrs read, GdalCrs::of(crs));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  char* made = nullptr;
  const bool is_made = gdal->export_wkt(read.handle(), &made) == OGRERR_NONE && made != nullptr;
  const std::string wkt = is_made ? made : "";
  gdal->release(made);
  if (!is_made) return fail("expected a CRS that WKT can say, got {}", quoted(crs));
  return without_controls(wkt);
}

}  // namespace lode::io
