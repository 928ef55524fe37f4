#include "lode/io/height_band.h"
#include "lode/io/ascii_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

#include "lode/io/text.h"

namespace lode::io {
namespace {

template <typename T>
constexpr GDALDataType kGdalType = GDT_Float64;
template <>
constexpr GDALDataType kGdalType<std::int16_t> = GDT_Int16;
template <>
constexpr GDALDataType kGdalType<std::uint16_t> = GDT_UInt16;
template <>
constexpr GDALDataType kGdalType<float> = GDT_Float32;

Result<void> check_in(std::int32_t y, const HeightGrid& grid, Progress* progress) {
  if (progress == nullptr || y % 64 != 0) return {};
  if (progress->is_cancelled()) return cancelled_error();
  progress->report("reading", static_cast<double>(y) / grid.n_rows);
  return {};
}

void set_missing(HeightGrid& grid, std::int32_t x, std::int32_t y) {
  if (grid.is_valid.empty()) grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 1);
  grid.is_valid[static_cast<std::size_t>(std::int64_t{y} * grid.n_columns + x)] = 0;
}

/// What a band says of which of its samples count.
struct BandMask {
  GDALRasterBandH band = nullptr;  ///< Zero where a sample is missing; null: there is none.
  std::optional<double> nodata{};
  bool is_of_user = false;  ///< That nodata is not the file's.
  bool is_float32 = false;  ///< So are samples, whatever they are read as.

  /// GDAL's mask is asked only for what samples themselves do not say; of colours for all.
  BandMask(const GdalRaster& raster, GDALRasterBandH of, const HeightReadOptions& options) {
    const GdalLibrary& gdal = raster.gdal();
    const bool is_encoded = options.encoding != HeightEncoding::none;
    const int known = is_encoded ? GMF_ALL_VALID : GMF_ALL_VALID | GMF_NODATA;
    if ((gdal.mask_flags(of) & known) == 0) band = gdal.mask_band(of);
    if (is_encoded) return;
    int has_nodata = 0;
    const double value = gdal.nodata(of, &has_nodata);
    if (has_nodata != 0) nodata = value;
    // Where heights are resampled it is told of the file's.
    is_of_user = options.nodata && !options.to_degrees;
    if (is_of_user) nodata = options.nodata;
    is_float32 = gdal.type(of) == GDT_Float32 || is_of_floats(raster, nodata);
  }
  /// ESRI ASCII grids that are read as doubles: what stands for a float has any digits.
  static bool is_of_floats(const GdalRaster& raster, const std::optional<double>& nodata) {
    return nodata && raster.format() == "AAIGrid" && stands_for_float(*nodata);
  }
  /// Of a sample as stored. Files and people say in decimals which float it is.
  [[nodiscard]] bool is_nodata(double sample) const {
    if (!nodata) return false;
    return is_float32 ? static_cast<float>(sample) == static_cast<float>(*nodata)
                      : sample == *nodata;
  }
  /// Of a row of the grid, which is row `of_file` of the file.
  Result<void> apply(const GdalRaster& raster, HeightGrid& grid, std::int32_t y,
                     std::int32_t of_file, std::vector<std::uint8_t>& row) const {
    if (band == nullptr) return {};
    row.resize(static_cast<std::size_t>(grid.n_columns));
    LODE_CHECK(raster.read_row(band, of_file, row.data(), GDT_Byte));
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      if (row[static_cast<std::size_t>(x)] == 0) set_missing(grid, x, y);
    return {};
  }
};

/// How stored numbers become heights.
struct Scaling {
  double scale = 1;
  double offset = 0;

  [[nodiscard]] bool is_plain() const { return scale == 1 && offset == 0; }
};

/// As GDAL before 3.7 says int8.
bool is_signed_byte(const GdalRaster& raster, GDALRasterBandH band) {
  const char* pixel = raster.gdal().metadata(band, "PIXELTYPE", "IMAGE_STRUCTURE");
  return pixel != nullptr && std::string_view(pixel) == "SIGNEDBYTE";
}

/// What a file of 64-bit integers has in the place of heights: as doubles it may be others, too.
std::optional<std::int64_t> own_nodata(const GdalLibrary& gdal, GDALRasterBandH band,
                                       std::int64_t /*of*/) {
  int is_there = 0;
  const std::int64_t value = gdal.nodata_int64(band, &is_there);
  return is_there != 0 ? std::optional(value) : std::nullopt;
}
std::optional<std::uint64_t> own_nodata(const GdalLibrary& gdal, GDALRasterBandH band,
                                        std::uint64_t /*of*/) {
  int is_there = 0;
  const std::uint64_t value = gdal.nodata_uint64(band, &is_there);
  return is_there != 0 ? std::optional(value) : std::nullopt;
}

/// A row of 64-bit integers as doubles, which hold those up to 2^53; NaN where one is missing.
template <typename T>
Result<void> read_wide(const GdalRaster& raster, GDALRasterBandH band, const BandMask& mask,
                       std::int32_t of_file, GDALDataType type, double* out) {
  constexpr double kMost = 9007199254740992;
  const std::optional<T> own = own_nodata(raster.gdal(), band, T{});
  std::vector<T> row(static_cast<std::size_t>(raster.n_columns()));
  LODE_CHECK(raster.read_row(band, of_file, row.data(), type));
  for (std::size_t x = 0; x < row.size(); ++x) {
    const auto z = static_cast<double>(row[x]);
    if (mask.is_of_user ? mask.is_nodata(z) : own == row[x]) {
      out[x] = std::numeric_limits<double>::quiet_NaN();
    } else if (std::abs(z) > kMost || (std::abs(z) == kMost && static_cast<T>(z) != row[x])) {
      return fail(
          "{}: expected integers up to 2^53, which doubles hold, got {} in column {}, row {}",
          raster.path(), row[x], x, of_file);
    } else {
      out[x] = z;
    }
  }
  return {};
}

template <typename T>
Result<void> read_stored(const GdalRaster& raster, GDALRasterBandH band, const BandMask& mask,
                         std::int32_t of_file, T* row) {
  if constexpr (std::is_same_v<T, double>) {
    const GDALDataType type = raster.gdal().type(band);
    if (type == GDT_Int64) return read_wide<std::int64_t>(raster, band, mask, of_file, type, row);
    if (type == GDT_UInt64) return read_wide<std::uint64_t>(raster, band, mask, of_file, type, row);
  }
  LODE_CHECK(raster.read_row(band, of_file, row, kGdalType<T>));
  if constexpr (std::is_same_v<T, std::int16_t> || std::is_same_v<T, double>)
    if (is_signed_byte(raster, band))
      for (std::int32_t x = 0; x < raster.n_columns(); ++x)
        if (row[x] > std::numeric_limits<std::int8_t>::max()) row[x] = static_cast<T>(row[x] - 256);
  return {};
}

template <typename T>
Result<HeightGrid> read_band(const GdalRaster& raster, GDALRasterBandH band, const BandMask& mask,
                             const Scaling& scaling, RasterRows rows, Progress* progress) {
  LODE_CHECK(raster.check_size(band, sizeof(T)));
  HeightGrid grid = make_height_grid<T>(raster.n_columns(), rows.n);
  auto& samples = std::get<HeightGrid::Samples<T>>(grid.heights);
  std::vector<std::uint8_t> mask_row;
  for (std::int32_t y = 0; y < grid.n_rows; ++y) {
    LODE_CHECK(check_in(y, grid, progress));
    T* row = samples.data() + y * grid.stride;
    LODE_CHECK(read_stored(raster, band, mask, rows.first + y, row));
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const auto z = static_cast<double>(row[x]);
      if (mask.is_nodata(z)) set_missing(grid, x, y);
      if constexpr (std::is_same_v<T, double>)
        if (!scaling.is_plain()) row[x] = z * scaling.scale + scaling.offset;
      if (!std::isfinite(static_cast<double>(row[x]))) set_missing(grid, x, y);
    }
    LODE_CHECK(mask.apply(raster, grid, y, rows.first + y, mask_row));
  }
  return grid;
}

Result<HeightGrid> read_typed(const GdalRaster& raster, const HeightReadOptions& options,
                              RasterRows rows, Progress* progress) {
  LODE_TRY(GDALRasterBandH band, raster.band(options.band_or_first()));
  const GdalLibrary& gdal = raster.gdal();
  GDALDataType type = gdal.type(band);
  const BandMask mask(raster, band, options);
  GDALRasterBandH of_file = raster.band_of_file(options.band_or_first());
  const Scaling scaling{gdal.scale(of_file, nullptr), gdal.offset(of_file, nullptr)};
  if (!std::isfinite(scaling.scale) || !std::isfinite(scaling.offset))
    return fail("{}: expected a finite scale and offset, got {} and {}", raster.path(),
                scaling.scale, scaling.offset);
  if (!scaling.is_plain()) type = GDT_Float64;
  switch (type) {
    case GDT_Byte:
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 7, 0)
    case GDT_Int8:
#endif
    case GDT_Int16: return read_band<std::int16_t>(raster, band, mask, scaling, rows, progress);
    case GDT_UInt16: return read_band<std::uint16_t>(raster, band, mask, scaling, rows, progress);
    case GDT_Float32: return read_band<float>(raster, band, mask, scaling, rows, progress);
    default: return read_band<double>(raster, band, mask, scaling, rows, progress);
  }
}

Result<void> check_unsigned(const GdalRaster& raster, GDALRasterBandH band) {
  if (is_signed_byte(raster, band))
    return fail("{}: expected unsigned bytes, got signed ones", raster.path());
  return {};
}

/// Of types that float64 holds exactly, and of 64-bit integers, which are looked at one by one.
Result<void> check_type(const GdalRaster& raster, GDALDataType type) {
  switch (type) {
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 7, 0)
    case GDT_Int8:
#endif
    case GDT_Byte:
    case GDT_Int16:
    case GDT_UInt16:
    case GDT_Int32:
    case GDT_UInt32:
    case GDT_Int64:
    case GDT_UInt64:
    case GDT_Float32:
    case GDT_Float64: return {};
    default:
      return fail("{}: expected integers or floats, got {}", raster.path(),
                  raster.gdal().type_name(type));
  }
}

/// What GDAL resamples as it is: 64-bit integers would be rounded without a word.
Result<void> check_resampled(const GdalRaster& raster, int number) {
  GDALRasterBandH of_file = raster.band_of_file(number);
  LODE_CHECK(check_unsigned(raster, of_file));
  const GDALDataType type = raster.gdal().type(of_file);
  if (type != GDT_Int64 && type != GDT_UInt64) return {};
  return fail("{}: expected integers of up to 32 bits or floats to be resampled, got {}",
              raster.path(), raster.gdal().type_name(type));
}

/// A colour as a height, correctly rounded.
double decode(HeightEncoding encoding, int red, int green, int blue) {
  if (encoding == HeightEncoding::terrain_rgb)
    return (65536 * red + 256 * green + blue - 100000) / 10.0;
  return 256 * red + green - 32768 + blue / 256.0;
}

template <typename T>
Result<HeightGrid> read_colors(const GdalRaster& raster, const HeightReadOptions& options,
                               RasterRows rows, Progress* progress) {
  std::array<GDALRasterBandH, 3> bands{};
  for (int i = 0; i < 3; ++i) {
    LODE_TRY(bands[static_cast<std::size_t>(i)], raster.band(i + 1));
    LODE_CHECK(raster.check_size(bands[static_cast<std::size_t>(i)], sizeof(T)));
  }
  const BandMask mask(raster, bands[0], options);
  HeightGrid grid = make_height_grid<T>(raster.n_columns(), rows.n);
  auto& samples = std::get<HeightGrid::Samples<T>>(grid.heights);
  const auto n = static_cast<std::size_t>(grid.n_columns);
  std::array<std::vector<std::uint8_t>, 3> color{};
  for (auto& row : color) row.resize(n);
  std::vector<std::uint8_t> mask_row;
  for (std::int32_t y = 0; y < grid.n_rows; ++y) {
    LODE_CHECK(check_in(y, grid, progress));
    for (std::size_t i = 0; i < 3; ++i)
      LODE_CHECK(raster.read_row(bands[i], rows.first + y, color[i].data(), GDT_Byte));
    for (std::size_t x = 0; x < n; ++x) {
      const double z = decode(options.encoding, color[0][x], color[1][x], color[2][x]);
      samples[static_cast<std::size_t>(y * grid.stride) + x] = static_cast<T>(z);
      if (options.nodata && z == *options.nodata)
        set_missing(grid, static_cast<std::int32_t>(x), y);
    }
    LODE_CHECK(mask.apply(raster, grid, y, rows.first + y, mask_row));
  }
  return grid;
}

Result<HeightRaster> describe_encoded(const GdalRaster& raster, const HeightReadOptions& options) {
  if (raster.n_bands() < 3)
    return fail("{}: expected three bands of colours to decode, got {}", raster.path(),
                raster.n_bands());
  // Others would be clamped to bytes as they are read.
  for (int number = 1; number <= 3; ++number) {
    LODE_TRY(GDALRasterBandH band, raster.band(number));
    const GDALDataType type = raster.gdal().type(band);
    if (type != GDT_Byte)
      return fail("{}: expected colours of a byte each to decode, got {} in band {}", raster.path(),
                  raster.gdal().type_name(type), number);
    LODE_CHECK(check_unsigned(raster, band));
  }
  HeightRaster result;
  result.type = options.encoding == HeightEncoding::terrarium ? "terrarium" : "terrain-rgb";
  result.grid.vertical_unit = "m";
  return result;
}

Result<HeightRaster> describe_plain(const GdalRaster& raster, const HeightReadOptions& options) {
  LODE_TRY(GDALRasterBandH band, raster.band(options.band_or_first()));
  const GdalLibrary& gdal = raster.gdal();
  const GDALDataType type = gdal.type(band);
  LODE_CHECK(check_type(raster, type));
  if (options.to_degrees) LODE_CHECK(check_resampled(raster, options.band_or_first()));
  if (raster.n_bands() >= 3 && type == GDT_Byte &&
      (raster.format() == "PNG" || raster.is_virtual()))
    return fail(
        "{}: expected to know what the colours of a picture stand for, terrain-rgb or terrarium, "
        "got no --encoding",
        raster.path());
  HeightRaster result;
  result.type = is_signed_byte(raster, band) ? "int8" : to_lower(gdal.type_name(type));
  GDALRasterBandH of_file = raster.band_of_file(options.band_or_first());
  if (gdal.scale(of_file, nullptr) != 1 || gdal.offset(of_file, nullptr) != 0)
    result.type = "scaled " + result.type;
  if (const char* unit = gdal.unit(of_file); unit != nullptr)
    result.grid.vertical_unit = without_controls(unit);
  result.form.nodata = BandMask(raster, band, options).nodata;
  return result;
}

/// Samples beside the outermost ones of a file that was put in degrees.
void fill_rim(const GdalRaster& raster, RasterRows rows, HeightGrid& grid) {
  if (grid.is_valid.empty()) return;
  const auto& rim = raster.rim();
  auto at = std::ranges::lower_bound(rim, rows.first, {}, &RimHeight::row);
  for (; at != rim.end() && at->row < rows.first + rows.n; ++at) {
    const std::int32_t y = at->row - rows.first;
    if (grid.has_height(at->column, y)) continue;
    std::visit(
        [&](auto& heights) {
          using T = std::remove_cvref_t<decltype(heights[0])>;
          heights[static_cast<std::size_t>(y * grid.stride + at->column)] =
              static_cast<T>(at->height);
        },
        grid.heights);
    grid.is_valid[static_cast<std::size_t>(std::int64_t{y} * grid.n_columns + at->column)] = 1;
  }
}

}  // namespace

Result<HeightRaster> describe_raster(const GdalRaster& raster, const HeightReadOptions& options) {
  const bool is_encoded = options.encoding != HeightEncoding::none;
  LODE_TRY(HeightRaster result,
           is_encoded ? describe_encoded(raster, options) : describe_plain(raster, options));
  result.grid.n_columns = raster.n_columns();
  result.grid.n_rows = raster.n_rows();
  result.format = raster.format();
  result.vertical.notes = raster.notes();
  LODE_CHECK(raster.place(result));
  return result;
}

Result<HeightGrid> read_rows(const GdalRaster& raster, const HeightReadOptions& options,
                             RasterRows rows, Progress* progress) {
  // Heights of 24 bits: float32 holds those of Terrarium, which are multiples of 1/256.
  switch (options.encoding) {
    case HeightEncoding::none: {
      LODE_TRY(HeightGrid grid, read_typed(raster, options, rows, progress));
      fill_rim(raster, rows, grid);
      return grid;
    }
    case HeightEncoding::terrarium: return read_colors<float>(raster, options, rows, progress);
    case HeightEncoding::terrain_rgb: return read_colors<double>(raster, options, rows, progress);
  }
  return HeightGrid{};
}

}  // namespace lode::io
