#include "lode/io/las_crs.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/little_endian.h"

namespace lode::io {
namespace {

constexpr std::uint16_t kWktRecord = 2112;
constexpr std::uint16_t kGeoKeyRecord = 34735;
constexpr const char* kProjection = "LASF_Projection";

/// A record behind its header.
struct Found {
  std::uint64_t offset = 0;
  std::uint64_t n_bytes = 0;
};

struct FoundRecords {
  std::optional<Found> wkt;
  std::optional<Found> geo_keys;

  void note(const LittleEndian& header, const Found& found) {
    if (header.text(2, 16) != kProjection) return;
    if (header.u16(18) == kWktRecord && !wkt) wkt = found;
    if (header.u16(18) == kGeoKeyRecord && !geo_keys) geo_keys = found;
  }
};

Result<void> find_records(const InputFile& file, const LasRecords& records, FoundRecords& found) {
  constexpr std::uint64_t kHeader = 54;
  std::array<std::byte, kHeader> bytes{};
  std::uint64_t at = records.first;
  for (std::uint32_t i = 0; i < records.n; ++i) {
    if (at + kHeader > records.end)
      return fail("{}: expected {} records before the points at offset {}, got {} up to there",
                  file.path(), records.n, records.end, i);
    LODE_CHECK(file.read(at, bytes));
    const LittleEndian header(bytes);
    const Found one{at + kHeader, header.u16(20)};
    if (one.offset + one.n_bytes > records.end)
      return fail("{}: expected records before the points at offset {}, got one of {} bytes at {}",
                  file.path(), records.end, one.n_bytes, at);
    found.note(header, one);
    at = one.offset + one.n_bytes;
  }
  return {};
}

/// Of LAS 1.4.
Result<void> find_extended(const InputFile& file, const LasRecords& records, FoundRecords& found) {
  constexpr std::uint64_t kHeader = 60;
  std::array<std::byte, kHeader> bytes{};
  std::uint64_t at = records.first_extended;
  for (std::uint32_t i = 0; i < records.n_extended; ++i) {
    if (file.size_from(at) < kHeader)
      return fail("{}: expected an extended record at offset {}, got a file of {} bytes",
                  file.path(), at, file.size());
    LODE_CHECK(file.read(at, bytes));
    const LittleEndian header(bytes);
    const Found one{at + kHeader, header.u64(20)};
    if (one.n_bytes > file.size_from(one.offset))
      return fail("{}: expected an extended record of {} bytes at offset {}, got a file of {}",
                  file.path(), one.n_bytes, at, file.size());
    found.note(header, one);
    at = one.offset + one.n_bytes;
  }
  return {};
}

Result<std::vector<std::byte>> read_record(const InputFile& file, const Found& found) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;
  if (found.n_bytes > kMostBytes)
    return fail("{}: expected a CRS of up to {} bytes at offset {}, got {}", file.path(),
                kMostBytes, found.offset, found.n_bytes);
  std::vector<std::byte> bytes(static_cast<std::size_t>(found.n_bytes));
  if (!bytes.empty()) LODE_CHECK(file.read(found.offset, bytes));
  return bytes;
}

/// GeoTIFF 1.0, 2.7 and 6.3: keys whose values stand in the directory itself.
struct GeoKeys {
  int epsg = 0;
  int vertical = 0;  ///< EPSG code, too; 0: none.
  bool is_user_defined = false;
  std::string vertical_unit;

  explicit GeoKeys(std::span<const std::byte> bytes) {
    constexpr std::uint16_t kGeographic = 2048;
    constexpr std::uint16_t kProjected = 3072;
    constexpr std::uint16_t kVertical = 4096;
    constexpr std::uint16_t kVerticalUnit = 4099;
    constexpr std::uint16_t kUserDefined = 32767;
    const LittleEndian at(bytes);
    int geographic = 0;
    for (std::size_t i = 8; i + 8 <= bytes.size(); i += 8) {
      const std::uint16_t key = at.u16(i);
      const std::uint16_t value = at.u16(i + 6);
      if (at.u16(i + 2) != 0) continue;
      if (key == kProjected && value == kUserDefined) is_user_defined = true;
      if (key == kProjected && value != kUserDefined) epsg = value;
      if (key == kGeographic && value != kUserDefined) geographic = value;
      if (key == kVertical && value != kUserDefined) vertical = vertical_crs(value);
      if (key == kVerticalUnit) vertical_unit = unit_name(value);
    }
    if (epsg == 0 && !is_user_defined) epsg = geographic;
  }
  /// GeoTIFF 1.0 numbered vertical CRS as EPSG does their datums: 5101 (Newlyn) to 5106 (Caspian),
  /// 5103 being NAVD88.
  static int vertical_crs(int code) {
    constexpr int kFirst = 5101;
    constexpr int kLast = 5106;
    constexpr int kCrsOfDatum = 600;
    return code >= kFirst && code <= kLast ? code + kCrsOfDatum : code;
  }
  static std::string unit_name(std::uint16_t code) {
    if (code == 9001) return "m";
    if (code == 9002) return "ft";
    return code == 9003 ? "us-ft" : "";
  }
};

/// Of WKT's vertical part.
std::string vertical_unit_of(const std::string& wkt) {
  const auto crs = GdalCrs::of(wkt);
  const auto gdal = GdalLibrary::get();
  if (!crs || !gdal) return {};
  const char* unit = (*gdal)->attribute(crs->handle(), "VERT_CS|UNIT", 0);
  return unit == nullptr ? "" : without_controls(unit);
}

/// The CRS that keys say, with its vertical part where GDAL knows that; else what is not known.
void take_codes(const GeoKeys& keys, LasCrs& crs) {
  if (keys.epsg == 0) {
    crs.note = "its GeoTIFF keys have no EPSG code";
    return;
  }
  const std::string code = fmt::format("EPSG:{}", keys.epsg);
  if (keys.vertical != 0)
    if (const auto whole = to_wkt(fmt::format("{}+{}", code, keys.vertical)); whole) {
      crs.wkt = *whole;
      return;
    }
  auto wkt = to_wkt(code);
  if (wkt)
    crs.wkt = std::move(wkt).value();
  else
    crs.note = wkt.error().message;
}

}  // namespace

Result<LasCrs> read_las_crs(const InputFile& file, const LasRecords& records, LasCrsUse use) {
  FoundRecords found;
  LODE_CHECK(find_records(file, records, found));
  LODE_CHECK(find_extended(file, records, found));
  LasCrs crs;
  if (found.wkt) {
    LODE_TRY(const std::vector<std::byte> bytes, read_record(file, *found.wkt));
    crs.wkt = without_controls(LittleEndian(bytes).text(0, bytes.size()));
  }
  if (found.geo_keys) {
    LODE_TRY(const std::vector<std::byte> bytes, read_record(file, *found.geo_keys));
    const GeoKeys keys(bytes);
    crs.vertical_unit = keys.vertical_unit;
    if (crs.wkt.empty() && use == LasCrsUse::wanted) take_codes(keys, crs);
  }
  if (crs.vertical_unit.empty() && !crs.wkt.empty()) crs.vertical_unit = vertical_unit_of(crs.wkt);
  if (use == LasCrsUse::ignored) crs.wkt.clear();
  return crs;
}

}  // namespace lode::io
