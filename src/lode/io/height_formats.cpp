#include "lode/io/height_formats.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>

#include "lode/io/height_hgt.h"
#include "lode/io/imported_raster.h"
#include "lode/io/point_reader.h"
#include "lode/io/text.h"
#include "lode/io/volume_reader.h"

namespace lode::io {
namespace {

using namespace std::string_view_literals;

constexpr std::array<const char*, 16> kDrivers{
    "SRTMHGT", "GTiff", "AAIGrid",     "PNG",  "USGSDEM", "EHdr",  "ENVI", "DTED",
    "HFA",     "SAGA",  "JP2OpenJPEG", "GSAG", "GSBG",    "GS7BG", "BT",   nullptr};

/// The first bytes; fewer of a shorter file, none of what cannot be read.
std::string head_of(const std::string& path, std::size_t n) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) return {};
  std::string head(n, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(n));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

bool is_tiff(const std::string& path) {
  const std::string head = head_of(path, 4);
  return head == "II*\0"sv || head == "MM\0*"sv || head == "II+\0"sv || head == "MM\0+"sv;
}

bool is_erdas(const std::string& path) {
  constexpr auto kSignature = "EHFA_HEADER_TAG"sv;
  return head_of(path, kSignature.size()) == kSignature;
}

/// x.hdr or x.img.hdr beside x.img, which starts with the format's name.
bool has_envi_header(const std::string& path) {
  const std::filesystem::path replaced = std::filesystem::path(path).replace_extension(".hdr");
  return head_of(replaced.string(), 4) == "ENVI" || head_of(path + ".hdr", 4) == "ENVI";
}

/// What the header beside a SAGA grid multiplies its values by, as it is written there; GDAL does
/// not. Empty: nothing.
std::string saga_factor(const std::string& path) {
  constexpr std::size_t kLongestHeader = 1 << 16;
  const std::filesystem::path header = std::filesystem::path(path).replace_extension(".sgrd");
  std::istringstream lines(head_of(header.string(), kLongestHeader));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find('=');
    if (at == std::string::npos || to_lower(trimmed(line.substr(0, at))) != "z_factor") continue;
    const std::string factor(trimmed(std::string_view(line).substr(at + 1)));
    return to_double(factor) == 1 ? std::string() : factor;
  }
  return {};
}

template <std::size_t N>
bool ends_with_any(const std::string& name, const std::array<const char*, N>& extensions) {
  return std::ranges::any_of(extensions,
                             [&](const char* extension) { return name.ends_with(extension); });
}

}  // namespace

std::span<const char* const> raster_drivers() { return std::span(kDrivers).subspan(1); }
std::span<const char* const> part_drivers() { return kDrivers; }

Result<void> check_raster_kind(const std::string& path) {
  // Its driver in GDAL 3.6 crashed on 3 of 70 damaged files.
  if (is_netcdf(path))
    return fail(
        "{}: expected a raster that GDAL may open here, got netCDF: gdal_translate makes a "
        "GeoTIFF of it",
        path);
  if (!to_lower(path).ends_with(".sdat")) return {};
  if (const std::string factor = saga_factor(path); !factor.empty())
    return fail("{}: expected a Z_FACTOR of 1 in its .sgrd, got {}", path, quoted(factor));
  return {};
}

bool is_height_path(const std::string& path) {
  if (is_hgt_path(path)) return true;
  const std::string name = to_lower(path);
  constexpr std::array kSure{".tif", ".tiff", ".asc", ".png", ".dem", ".bil",
                             ".flt", ".dt0",  ".dt1", ".dt2", ".jp2", ".sdat",
                             ".nc",  ".nc4",  ".cdf", ".grd", ".bt",  ".vrt"};
  if (ends_with_any(name, kSure) || is_imported_path(path)) return true;
  constexpr std::array kOfEnvi{".img", ".dat", ".bip", ".bsq"};
  if (ends_with_any(name, kOfEnvi) && has_envi_header(path)) return true;
  if (name.ends_with(".img")) return is_erdas(path);
  // Meshes of Exodus and CGNS are netCDF and HDF5, too.
  constexpr std::array kOfMeshes{".e", ".exo", ".ex2", ".g", ".cgns"};
  if (is_volume_path(path) || is_point_path(path)) return false;
  return is_tiff(path) || (!ends_with_any(name, kOfMeshes) && is_netcdf(path));
}

}  // namespace lode::io
