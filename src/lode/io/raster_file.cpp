#include "lode/io/raster_file.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/core/staged_file.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/text.h"
#include "lode/io/vertical_options.h"

namespace lode::io {

bool is_geotiff_path(const std::string& path) {
  const std::string name = to_lower(path);
  return name.ends_with(".tif") || name.ends_with(".tiff");
}

struct RasterWriter::Impl {
  const GdalLibrary* gdal;
  std::string path;
  RasterLayer layer;
  StagedFile staged;
  GDALDatasetH dataset = nullptr;
  GDALRasterBandH band = nullptr;
  std::int32_t n_written = 0;  ///< Rows.

  Impl(const GdalLibrary* library, std::string file, RasterLayer wanted, StagedFile stage)
      : gdal(library), path(std::move(file)), layer(std::move(wanted)), staged(std::move(stage)) {
    gdal->push_error_handler(gdal->quiet_handler);
    gdal->reset_errors();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (dataset != nullptr) gdal->close(dataset);
    gdal->pop_error_handler();
  }

  [[nodiscard]] Error cannot(const char* action) const {
    const std::string reason = without_controls(gdal->last_error());
    return fail("{}: cannot {}: {}", path, action, reason.empty() ? "GDAL says no more" : reason);
  }

  Result<void> open() {
    GDALDriverH driver = gdal->driver_named("GTiff");
    if (driver == nullptr)
      return fail("{}: expected a GDAL that writes GeoTIFF, got one that does not", path);
    std::array<std::string, 6> texts{"TILED=YES",        "BLOCKXSIZE=256", "BLOCKYSIZE=256",
                                     "COMPRESS=DEFLATE", "PREDICTOR=3",    "BIGTIFF=IF_SAFER"};
    std::array<char*, texts.size() + 1> options{};
    std::ranges::transform(texts, options.begin(), [](std::string& text) { return text.data(); });
    const GDALDataType type = layer.type == RasterType::float32 ? GDT_Float32 : GDT_Float64;
    dataset = gdal->create(driver, staged.name().c_str(), layer.n_columns, layer.n_rows, 1, type,
                           options.data());
    band = dataset == nullptr ? nullptr : gdal->band(dataset, 1);
    if (band == nullptr) return cannot("make the file");
    return describe();
  }

  /// Before the first sample, as the file's head stands before them.
  Result<void> describe() {
    if (!layer.crs.empty()) {
      LODE_TRY(const GdalCrs crs, GdalCrs::of(to_geotiff_crs(layer.crs)));
      if (gdal->set_crs(dataset, crs.handle()) != CE_None) return cannot("write its CRS");
    }
    if (layer.geotransform &&
        gdal->set_geotransform(dataset, layer.geotransform->data()) != CE_None)
      return cannot("write its position");
    gdal->set_metadata(dataset, "AREA_OR_POINT", layer.is_point ? "Point" : "Area", nullptr);
    if (!layer.comment.empty())
      gdal->set_metadata(dataset, "TIFFTAG_IMAGEDESCRIPTION", layer.comment.c_str(), nullptr);
    if (gdal->set_nodata(band, layer.nodata) != CE_None) return cannot("write its nodata value");
    if (!layer.unit.empty()) gdal->set_unit(band, layer.unit.c_str());
    if (!layer.name.empty()) gdal->set_description(band, layer.name.c_str());
    return {};
  }
};

RasterWriter::RasterWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RasterWriter::RasterWriter(RasterWriter&&) noexcept = default;
RasterWriter::~RasterWriter() = default;

Result<RasterWriter> RasterWriter::create(const std::string& path, const RasterLayer& layer) try {
  LODE_EXPECTS(layer.n_columns > 0 && layer.n_rows > 0);
  if (!is_geotiff_path(path)) return fail("{}: expected a file that ends in .tif or .tiff", path);
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  LODE_TRY(StagedFile staged, StagedFile::create(path));
  auto impl = std::make_unique<Impl>(gdal, path, layer, std::move(staged));
  LODE_CHECK(impl->open());
  return RasterWriter(std::move(impl));
} catch (const std::bad_alloc&) {
  return out_of_memory("write the raster", path);
}

Result<void> RasterWriter::add_rows(std::span<const double> samples) try {
  const std::int32_t n_columns = impl_->layer.n_columns;
  const std::int32_t n = std::min(kTileRows, impl_->layer.n_rows - impl_->n_written);
  LODE_EXPECTS(samples.size() == static_cast<std::size_t>(n) * static_cast<std::size_t>(n_columns));
  // GDAL reads alone what it is given to write.
  if (impl_->gdal->read(impl_->band, GF_Write, 0, impl_->n_written, n_columns, n,
                        const_cast<double*>(samples.data()), n_columns, n, GDT_Float64, 0,
                        0) != CE_None)
    return impl_->cannot("write its rows");
  impl_->n_written += n;
  return {};
} catch (const std::bad_alloc&) {
  return out_of_memory("write the raster", impl_->path);
}

Result<void> RasterWriter::commit(const Progress& progress) try {
  LODE_EXPECTS(impl_->n_written == impl_->layer.n_rows);
  const GdalLibrary& gdal = *impl_->gdal;
  // Closing writes what is left, and says nothing but by messages.
  gdal.reset_errors();
  gdal.close(std::exchange(impl_->dataset, nullptr));
  if (gdal.last_error_kind() >= CE_Failure) return impl_->cannot("finish the file");
  // Where GDAL puts what a GeoTIFF has no place for.
  std::error_code status;
  if (std::filesystem::exists(impl_->staged.name() + ".aux.xml", status))
    return fail("{}: expected a CRS that a GeoTIFF can have, got one that it has not", impl_->path);
  return impl_->staged.commit(progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the raster", impl_->path);
}

}  // namespace lode::io
