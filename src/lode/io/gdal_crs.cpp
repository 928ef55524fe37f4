#include "lode/io/gdal_crs.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "lode/io/gdal_raster.h"
#include "lode/io/text.h"

namespace lode::io {

namespace {

int to_code(std::string_view digits) {
  constexpr std::int64_t kMostCode = 1 << 20;
  return static_cast<int>(std::clamp<std::int64_t>(to_int64(digits).value_or(0), 0, kMostCode));
}

struct EpsgCodes {
  int first = 0;
  std::optional<int> vertical{};
};

/// Of EPSG:N and EPSG:N+M; none of other text.
std::optional<EpsgCodes> epsg_codes(const std::string& text) {
  constexpr std::string_view kPrefix = "epsg:";
  if (!to_lower(text).starts_with(kPrefix)) return std::nullopt;
  const std::string_view codes = std::string_view(text).substr(kPrefix.size());
  const std::size_t plus = codes.find('+');
  EpsgCodes found{.first = to_code(codes.substr(0, plus))};
  if (plus != std::string_view::npos) found.vertical = to_code(codes.substr(plus + 1));
  return found;
}

bool import_codes(const GdalLibrary& gdal, OGRSpatialReferenceH crs, const EpsgCodes& codes) {
  if (!codes.vertical) return gdal.import_epsg(crs, codes.first) == OGRERR_NONE;
  OGRSpatialReferenceH first = gdal.new_crs(nullptr);
  OGRSpatialReferenceH second = gdal.new_crs(nullptr);
  const bool is_made =
      gdal.import_epsg(first, codes.first) == OGRERR_NONE && gdal.is_vertical(first) == 0 &&
      gdal.import_epsg(second, *codes.vertical) == OGRERR_NONE && gdal.is_vertical(second) != 0;
  const auto name_of = [&](OGRSpatialReferenceH one) {
    for (const char* part : {"PROJCS", "GEOGCS", "VERT_CS"})
      if (const char* name = gdal.attribute(one, part, 0); name != nullptr)
        return std::string(name);
    return std::string("unnamed");
  };
  const bool is_joined =
      is_made && gdal.set_compound(crs, (name_of(first) + " + " + name_of(second)).c_str(), first,
                                   second) == OGRERR_NONE;
  gdal.destroy_crs(first);
  gdal.destroy_crs(second);
  return is_joined;
}

}  // namespace

Result<GdalCrs> GdalCrs::of(const std::string& text) {
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  gdal->push_error_handler(gdal->quiet_handler);
  GdalCrs crs(gdal, gdal->new_crs(nullptr));
  const auto import = [&] {
    if (const auto codes = epsg_codes(text)) return import_codes(*gdal, crs.handle_, *codes);
    std::string wkt = text;
    char* at = wkt.data();
    return gdal->import_wkt(crs.handle_, &at) == OGRERR_NONE;
  };
  if (crs.handle_ == nullptr || !import())
    return fail("expected a CRS as WKT, EPSG:N or EPSG:N+M, got {}", quoted(text));
  gdal->set_axis_order(crs.handle_, OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

GdalCrs::~GdalCrs() {
  if (gdal_ == nullptr) return;
  gdal_->destroy_crs(handle_);
  gdal_->pop_error_handler();
}

void GdalCrs::strip_heights() const {
  gdal_->strip_vertical(handle_);
  gdal_->strip_height(handle_, nullptr);
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

Result<std::string> to_horizontal_wkt(const std::string& crs) {
  LODE_TRY(const GdalCrs read, GdalCrs::of(crs));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  const bool is_horizontal = gdal->is_geographic(read.handle()) != 0 ||
                             gdal->is_projected(read.handle()) != 0 ||
                             gdal->is_local(read.handle()) != 0;
  if (is_horizontal) return to_wkt(crs);
  const char* kind = gdal->is_geocentric(read.handle()) != 0 ? "a geocentric one, of x, y and z"
                     : gdal->is_vertical(read.handle()) != 0
                         ? "one of heights alone, which --vertical-crs takes"
                         : "another one";
  return fail(
      "expected a CRS of x and y, geographic or projected, perhaps with heights, got {}: {}", kind,
      quoted(crs));
}

Result<void> check_same_crs(const std::string& path, const std::string& own,
                            const std::string& stated) {
  const auto of_file = GdalCrs::of(own);
  const auto of_user = GdalCrs::of(stated);
  if (!of_file) return fail("{}: {}", path, of_file.error().message);
  if (!of_user) return fail("{}: {}", path, of_user.error().message);
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  // Files beside grids do not say the order of axes, which is that of the grid's.
  constexpr std::array<const char*, 3> kBut{"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                            "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS",
                                            nullptr};
  if (gdal->is_same_crs_but(of_file->handle(), of_user->handle(), kBut.data()) != 0) return {};
  return fail("{}: expected no CRS for a raster that has one of its own, {}, got another: {}", path,
              quoted(own), quoted(stated));
}

}  // namespace lode::io
