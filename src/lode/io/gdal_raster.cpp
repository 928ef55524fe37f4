#include "lode/io/gdal_raster.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "lode/io/ascii_grid.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/height_formats.h"
#include "lode/io/input_file.h"
#include "lode/io/text.h"
#include "lode/io/virtual_raster.h"
#include "lode/io/virtual_sources.h"

namespace lode::io {

namespace {

constexpr const char* kOpenFiles = "GDAL_MAX_DATASET_POOL_SIZE";

/// A row of a mosaic may be in hundreds of files, which should stay open until the next one.
std::uint64_t most_open_files() {
  constexpr std::uint64_t kFew = 8;
  constexpr std::uint64_t kMany = 450;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return kFew;
  return std::clamp<std::uint64_t>(limit.rlim_cur / 2, kFew, kMany);
}

/// GDAL's word for a GeoTIFF that says whether samples are points and nothing of a CRS.
bool is_empty_crs(std::string_view wkt) {
  return wkt.starts_with(R"(LOCAL_CS["unnamed",UNIT["unknown")");
}

}  // namespace

std::string without_controls(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return text;
}

Result<GdalRaster> GdalRaster::open(const std::string& path, const HeightReadOptions& options,
                                    Progress& progress) {
  // GDAL takes URLs and the text of some formats for names, too.
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  const bool has_variables = is_netcdf(path);
  const bool is_imported = has_variables || is_imported_path(path);
  if (!is_imported) LODE_CHECK(check_raster_kind(path));
  if (!has_variables && !options.variable.empty())
    return fail("{}: expected a netCDF file to choose a variable of, '{}', got another raster",
                path, options.variable);
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  gdal->push_error_handler(gdal->quiet_handler);
  gdal->reset_errors();
  // Files of GeoTIFF 1.0 have vertical CRS, too, of which GDAL is silent unless asked.
  gdal->set_option("GTIFF_REPORT_COMPD_CS", "YES");
  GdalRaster raster(path, gdal, file->size());
  if (is_imported) {
    LODE_CHECK(raster.open_imported(options, progress));
    return raster;
  }
  const std::string type = ascii_grid_type(path);
  const std::string type_option = "DATATYPE=" + type;
  const std::array<const char*, 2> open_options{type.empty() ? nullptr : type_option.c_str(),
                                                nullptr};
  if (is_virtual_raster(path)) {
    LODE_CHECK(raster.open_virtual());
    return raster;
  }
  raster.dataset_ = gdal->open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                               raster_drivers().data(), open_options.data(), nullptr);
  if (raster.dataset_ == nullptr)
    return fail("{}: expected {}, got: {}", path, kRasterFormats, raster.reason());
  return raster;
}

Result<void> GdalRaster::open_virtual() {
  constexpr std::array<const char*, 2> kVirtual{"VRT", nullptr};
  LODE_TRY(CheckedVirtualRaster checked, check_virtual_raster(path_, *gdal_));
  is_virtual_ = true;
  n_file_bytes_ += checked.n_bytes;
  band_faults_ = std::move(checked.faults);
  n_part_block_rows_ = checked.n_block_rows;
  gdal_->set_option(kOpenFiles, fmt::format("{}", most_open_files()).c_str());
  gdal_->reset_errors();
  dataset_ = gdal_->open(checked.text.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kVirtual.data(),
                         nullptr, nullptr);
  if (dataset_ != nullptr) return {};
  return fail("{}: expected a VRT of heights, got: {}", path_, reason());
}

Result<void> GdalRaster::open_imported(const HeightReadOptions& options, Progress& progress) {
  constexpr std::array<const char*, 2> kTiff{"GTiff", nullptr};
  LODE_TRY(ImportedRaster made, import_raster(path_,
                                              {.variable = options.variable,
                                               .layer = options.band,
                                               .crs_is_stated = !options.crs.empty(),
                                               .nodata_is_stated = options.nodata.has_value()},
                                              progress));
  imported_.emplace(std::move(made));
  gdal_->reset_errors();
  dataset_ = gdal_->open(imported_->name().c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kTiff.data(),
                         nullptr, nullptr);
  if (dataset_ == nullptr)
    return fail("{}: expected a copy of it that GDAL reads, got: {}", path_, reason());
  stated_crs_ = imported_->crs;
  if (!imported_->is_in_plain_degrees || !options.crs.empty()) return {};
  LODE_TRY(stated_crs_, to_horizontal_wkt("EPSG:4326"));
  imported_->notes.emplace_back(
      "its longitudes and latitudes are taken for those of WGS 84, as the file does not say: --crs "
      "says it");
  return {};
}

std::vector<std::string> GdalRaster::notes() const {
  if (imported_) return imported_->notes;
  // Pages of a TIFF are subdatasets; of one page there are none.
  if (gdal_->metadata(dataset_, "SUBDATASET_2_NAME", "SUBDATASETS") == nullptr) return {};
  return {
      "it holds several pages, of which the first is read: others are for another file each, as "
      "gdal_translate GTIFF_DIR:2:IN OUT makes them"};
}

GdalRaster::~GdalRaster() {
  if (gdal_ == nullptr) return;
  if (dataset_ != nullptr) gdal_->close(dataset_);
  if (source_ != nullptr) gdal_->close(source_);
  gdal_->set_option("GTIFF_REPORT_COMPD_CS", nullptr);
  gdal_->set_option(kOpenFiles, nullptr);
  gdal_->pop_error_handler();
}

std::string GdalRaster::format() const {
  if (imported_) return imported_->format;
  GDALDriverH driver = gdal_->driver(source_ != nullptr ? source_ : dataset_);
  return driver == nullptr ? "unknown" : gdal_->driver_name(driver);
}

std::string GdalRaster::reason() const {
  std::string text = without_controls(gdal_->last_error());
  return text.empty() ? "nothing that it knows" : text;
}

Result<GDALRasterBandH> GdalRaster::band(int number) const {
  if (imported_) number = 1;
  if (number < 1 || number > n_bands())
    return fail("{}: expected a band from 1 to {}, got {}", path_, n_bands(), number);
  GDALRasterBandH found = gdal_->band(dataset_, number);
  if (found == nullptr) return fail("{}: expected band {}, got: {}", path_, number, reason());
  const bool has_mask = (gdal_->mask_flags(found) & (GMF_PER_DATASET | GMF_ALPHA)) != 0;
  const auto place = static_cast<std::size_t>(number) - 1;
  if (!has_mask && place < band_faults_.size() && !band_faults_[place].empty())
    return fail("{}: {}", path_, band_faults_[place]);
  return found;
}

Result<void> GdalRaster::check_size(GDALRasterBandH band, std::uint64_t n_bytes) const {
  // What deflate can do at most; other codecs, and files that leave empty blocks out, do better on
  // rasters with little in them, and smaller ones may.
  constexpr std::uint64_t kRatio = 1032;
  constexpr std::uint64_t kSmall = std::uint64_t{512} << 20;
  if (n_columns() < 1 || n_rows() < 1)
    return fail("{}: expected samples, got {} x {}", path_, n_columns(), n_rows());
  const auto is_too_much = [&](int columns, int rows, std::uint64_t n_sample) {
    const std::uint64_t n = static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows);
    return n > kSmall / n_sample && n / kRatio > n_file_bytes_ / n_sample;
  };
  if (source_ != nullptr) return {};  // which was looked at, and n of which there may be
  int block_columns = 0;
  int block_rows = 0;
  gdal_->block_size(band, &block_columns, &block_rows);
  constexpr std::uint64_t kLargestType = 8;
  if (is_too_much(block_columns, block_rows, kLargestType))
    return fail("{}: expected a file that can hold blocks of {} x {} samples, got {}", path_,
                block_columns, block_rows, format_bytes(n_file_bytes_));
  if (is_too_much(n_columns(), n_rows(), n_bytes))
    return fail("{}: expected a file that can hold {} x {} samples, got {}", path_, n_columns(),
                n_rows(), format_bytes(n_file_bytes_));
  return {};
}

std::string GdalRaster::crs() const {
  const char* own = gdal_->projection(source_ != nullptr ? source_ : dataset_);
  if (own == nullptr || *own == '\0' || is_empty_crs(own)) return stated_crs_;
  return without_controls(own);
}

Result<void> GdalRaster::state_crs(const std::string& crs) {
  if (crs.empty()) return {};
  const std::string own = this->crs();
  if (!own.empty()) return check_same_crs(path_, own, crs);
  auto wkt = to_horizontal_wkt(crs);
  if (!wkt) return fail("{}: {}", path_, wkt.error().message);
  stated_crs_ = std::move(wkt).value();
  return {};
}

Result<void> GdalRaster::place(HeightRaster& raster) const {
  HeightGrid& grid = raster.grid;
  std::array<double, 6> g{};
  raster.has_place = gdal_->geotransform(dataset_, g.data()) == CE_None;
  if (!raster.has_place && !stated_crs_.empty())
    return fail(
        "{}: expected a raster that says where it is, as a world file beside it does, for a CRS to "
        "be stated, got none",
        path_);
  grid.crs = crs();
  if (source_ != nullptr) {
    LODE_TRY(grid.crs, crs_of_degrees());
  }
  if (!raster.has_place) {
    grid.to_world = {0, 1, 0, static_cast<double>(grid.n_rows - 1), 0, -1};
    return {};
  }
  raster.form.geotransform = g;
  const char* pixel = gdal_->metadata(dataset_, "AREA_OR_POINT", nullptr);
  raster.form.is_point = pixel != nullptr && std::string_view(pixel) == "Point";
  if (imported_) raster.form.is_point = imported_->is_of_points;
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
