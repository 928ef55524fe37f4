#include "lode/io/gdal_raster.h"

#include <cmath>

#include "lode/io/input_file.h"
#include "lode/io/text.h"

namespace lode::io {

Result<GdalRaster> GdalRaster::open(const std::string& path) {
  // GDAL takes URLs and the text of some formats for names, too.
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  gdal->push_error_handler(gdal->quiet_handler);
  gdal->reset_errors();
  GdalRaster raster(path, gdal, file->size());
  raster.dataset_ =
      gdal->open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr);
  if (raster.dataset_ == nullptr)
    return fail("{}: expected a raster that GDAL reads, got: {}", path, raster.reason());
  return raster;
}

GdalRaster::~GdalRaster() {
  if (gdal_ == nullptr) return;
  if (dataset_ != nullptr) gdal_->close(dataset_);
  gdal_->pop_error_handler();
}

std::string GdalRaster::format() const {
  GDALDriverH driver = gdal_->driver(dataset_);
  return driver == nullptr ? "unknown" : gdal_->driver_name(driver);
}

std::string GdalRaster::reason() const {
  std::string text = gdal_->last_error();
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text.empty() ? "nothing that it knows" : text;
}

Result<GDALRasterBandH> GdalRaster::band(int number) const {
  if (number < 1 || number > n_bands())
    return fail("{}: expected a band from 1 to {}, got {}", path_, n_bands(), number);
  GDALRasterBandH found = gdal_->band(dataset_, number);
  if (found == nullptr) return fail("{}: expected band {}, got: {}", path_, number, reason());
  return found;
}

Result<void> GdalRaster::check_size(std::uint64_t n_bytes) const {
  // What deflate can do at most; other codecs do better on empty rasters only, and small ones may.
  constexpr std::uint64_t kRatio = 1032;
  constexpr std::uint64_t kSmall = std::uint64_t{64} << 20;
  if (n_columns() < 1 || n_rows() < 1)
    return fail("{}: expected samples, got {} x {}", path_, n_columns(), n_rows());
  const std::uint64_t n =
      static_cast<std::uint64_t>(n_columns()) * static_cast<std::uint64_t>(n_rows()) * n_bytes;
  if (n > kSmall && n / kRatio > n_file_bytes_)
    return fail("{}: expected a file that can hold {} x {} samples, got {}", path_, n_columns(),
                n_rows(), format_bytes(n_file_bytes_));
  return {};
}

Result<void> GdalRaster::place(HeightRaster& raster) const {
  HeightGrid& grid = raster.grid;
  std::array<double, 6> g{};
  raster.has_place = gdal_->geotransform(dataset_, g.data()) == CE_None;
  if (const char* crs = gdal_->projection(dataset_); crs != nullptr) grid.crs = crs;
  if (!raster.has_place) {
    grid.to_world = {0, 1, 0, static_cast<double>(grid.n_rows - 1), 0, -1};
    return {};
  }
  // GDAL has moved what is given at samples to the corners of pixels.
  grid.to_world = {g[0] + (g[1] + g[2]) / 2, g[1], g[2], g[3] + (g[4] + g[5]) / 2, g[4], g[5]};
  const double determinant = g[1] * g[5] - g[2] * g[4];
  if (!std::isfinite(determinant) || determinant == 0 || !std::isfinite(g[0]) ||
      !std::isfinite(g[3]))
    return fail("{}: expected columns and rows in two directions, got the geotransform {}", path_,
                fmt::join(g, ", "));
  return {};
}

Result<void> GdalRaster::read_row(GDALRasterBandH band, std::int32_t y, void* out,
                                  GDALDataType type) const {
  if (gdal_->read(band, GF_Read, 0, y, n_columns(), 1, out, n_columns(), 1, type, 0, 0) == CE_None)
    return {};
  return fail("{}: expected samples of row {}, got: {}", path_, y, reason());
}

}  // namespace lode::io
