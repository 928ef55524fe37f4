#include "lode/io/height_hgt.h"

#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "lode/io/byte_stream.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/inflate.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::int16_t kVoid = -32768;
/// Of 1/3 arc second, three times the finest that is published.
constexpr std::uint64_t kMaxSide = 10801;

constexpr const char* kWgs84 =
    R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,)"
    R"(AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0],)"
    R"(UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]])";

struct Corner {
  double longitude, latitude;
};

/// N46W123...: the south-western corner.
std::optional<Corner> parse_corner(const std::string& path) {
  const std::string name = to_lower(path.substr(path.find_last_of('/') + 1));
  if (name.size() < 7) return std::nullopt;
  const auto latitude = to_uint64(std::string_view(name).substr(1, 2));
  const auto longitude = to_uint64(std::string_view(name).substr(4, 3));
  const bool has_letters = (name[0] == 'n' || name[0] == 's') && (name[3] == 'e' || name[3] == 'w');
  if (!has_letters || !latitude || !longitude) return std::nullopt;
  const auto x = static_cast<double>(*longitude);
  const auto y = static_cast<double>(*latitude);
  return Corner{name[3] == 'e' ? x : -x, name[0] == 'n' ? y : -y};
}

/// All that there is, at most one sample more than the largest tile.
Result<std::vector<std::byte>> read_all_bytes(const std::string& path) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  std::unique_ptr<ByteStream> stream = make_file_stream(file, 0);
  constexpr std::size_t kLimit = 2 * (kMaxSide * kMaxSide + 1);
  std::vector<std::byte> bytes;
  if (!to_lower(path).ends_with(".gz")) {
    bytes.resize(std::min<std::uint64_t>(file->size(), kLimit));
    LODE_CHECK(stream->read(bytes));
    return bytes;
  }
  InflateStream inflated(std::move(stream), path);
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  std::size_t n = 0;
  for (std::size_t n_read = 1; n_read > 0 && n < kLimit; n += n_read) {
    bytes.resize(n + kPiece);
    LODE_TRY(n_read, inflated.read_some(std::span(bytes).subspan(n, kPiece)));
  }
  bytes.resize(n);
  return bytes;
}

std::int16_t from_big_endian(const std::byte* at) {
  return static_cast<std::int16_t>(std::to_integer<std::uint16_t>(at[0]) << 8 |
                                   std::to_integer<std::uint16_t>(at[1]));
}

}  // namespace

bool is_hgt_path(const std::string& path) {
  const std::string name = to_lower(path);
  return name.ends_with(".hgt") || name.ends_with(".hgt.gz");
}

Result<HeightRaster> read_hgt(const std::string& path, const HeightReadOptions& options) {
  const auto corner = parse_corner(path);
  if (!corner)
    return fail("{}: expected a name that starts with a corner, such as N46W123.hgt, got another",
                path);
  LODE_TRY(const std::vector<std::byte> bytes, read_all_bytes(path));
  const std::size_t n_samples = bytes.size() / 2;
  const auto side = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(n_samples)));
  if (side < 2 || side > kMaxSide || 2 * side * side != bytes.size())
    return fail("{}: expected a square of 16-bit samples, such as 2 x 1201 x 1201 bytes, got {}",
                path, bytes.size());
  const auto n = static_cast<std::int32_t>(side);
  HeightRaster raster{make_height_grid<std::int16_t>(n, n), "HGT", "int16", true, {}, {}};
  HeightGrid& grid = raster.grid;
  auto& samples = std::get<HeightGrid::Samples<std::int16_t>>(grid.heights);
  const double missing = options.nodata.value_or(kVoid);
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const auto i = static_cast<std::size_t>(std::int64_t{y} * n + x);
      const std::int16_t z = from_big_endian(bytes.data() + 2 * i);
      samples[static_cast<std::size_t>(y * grid.stride + x)] = z;
      if (static_cast<double>(z) != missing) continue;
      if (grid.is_valid.empty()) grid.is_valid.assign(static_cast<std::size_t>(side * side), 1);
      grid.is_valid[i] = 0;
    }
  const double step = 1.0 / (n - 1);
  grid.to_world = {corner->longitude, step, 0, corner->latitude + 1, 0, -step};
  grid.crs = kWgs84;
  if (!options.crs.empty()) LODE_CHECK(check_same_crs(path, grid.crs, options.crs));
  grid.vertical_unit = "m";
  raster.form.nodata = missing;
  raster.form.is_point = true;
  return raster;
}

}  // namespace lode::io
