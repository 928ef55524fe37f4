#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/io/degrees_rim.h"
#include "lode/io/gdal_library.h"
#include "lode/io/height_reader.h"
#include "lode/io/imported_raster.h"

namespace lode::io {

/// With spaces in place of control characters, which would reach terminals.
[[nodiscard]] std::string without_controls(std::string text);

/// A raster file open in GDAL, whose messages are kept from stderr meanwhile.
class GdalRaster {
 public:
  /// Fails on what is no regular file, or no raster. Of the options a variable, band, nodata and
  /// CRS matter, which import_raster() is told of; `progress` is told of what that does.
  [[nodiscard]] static Result<GdalRaster> open(const std::string& path,
                                               const HeightReadOptions& options,
                                               Progress& progress);

  GdalRaster(const GdalRaster&) = delete;
  GdalRaster& operator=(const GdalRaster&) = delete;
  GdalRaster(GdalRaster&& other) noexcept
      : path_(std::move(other.path_)),
        gdal_(std::exchange(other.gdal_, nullptr)),
        dataset_(std::exchange(other.dataset_, nullptr)),
        source_(std::exchange(other.source_, nullptr)),
        rim_(std::move(other.rim_)),
        stated_crs_(std::move(other.stated_crs_)),
        is_virtual_(other.is_virtual_),
        band_faults_(std::move(other.band_faults_)),
        n_part_block_rows_(other.n_part_block_rows_),
        imported_(std::move(other.imported_)),
        n_file_bytes_(other.n_file_bytes_) {}
  GdalRaster& operator=(GdalRaster&&) = delete;
  ~GdalRaster();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const GdalLibrary& gdal() const { return *gdal_; }
  [[nodiscard]] int n_bands() const { return gdal_->n_bands(dataset_); }
  /// What reading took for granted.
  [[nodiscard]] std::vector<std::string> notes() const;
  [[nodiscard]] std::string format() const;
  /// Whether it is put together from other files,
  [[nodiscard]] bool is_virtual() const { return is_virtual_; }
  /// whose tallest block has so many rows; 1 otherwise.
  [[nodiscard]] std::int32_t n_part_block_rows() const { return n_part_block_rows_; }
  /// Fails where there is no such band, counted from 1, or where samples of one that is put
  /// together from files are no heights. Of netCDF it is always what was chosen when it was opened.
  [[nodiscard]] Result<GDALRasterBandH> band(int number) const;
  /// The file's own, which says what numbers stand for also where band() is of degrees.
  [[nodiscard]] GDALRasterBandH band_of_file(int number) const {
    return gdal_->band(source_ != nullptr ? source_ : dataset_, imported_ ? 1 : number);
  }
  /// Of samples of n_bytes in memory, and of the band's own blocks: held against what a file of its
  /// size can have.
  [[nodiscard]] Result<void> check_size(GDALRasterBandH band, std::uint64_t n_bytes) const;
  [[nodiscard]] std::int32_t n_columns() const { return gdal_->n_columns(dataset_); }
  [[nodiscard]] std::int32_t n_rows() const { return gdal_->n_rows(dataset_); }
  /// Says what CRS it is in, as GdalCrs::of() takes it; nothing where that is empty. Fails where
  /// the file has another one.
  [[nodiscard]] Result<void> state_crs(const std::string& crs);
  /// As WKT: the file's own or the one that was stated; empty: not known.
  [[nodiscard]] std::string crs() const;
  /// Becomes what HeightReadOptions::to_degrees says, sample by sample as they are read. Fails
  /// where GDAL cannot do that.
  [[nodiscard]] Result<void> put_in_degrees(Resampling resampling,
                                            const HeightReadOptions& options);
  /// Of one in degrees: heights of samples that have none otherwise, by row and column.
  [[nodiscard]] const std::vector<RimHeight>& rim() const { return rim_; }
  /// Position and CRS; fails where the position is degenerate.
  [[nodiscard]] Result<void> place(HeightRaster& raster) const;
  /// Fills a whole row, `type` as in memory.
  [[nodiscard]] Result<void> read_row(GDALRasterBandH band, std::int32_t y, void* out,
                                      GDALDataType type) const;
  /// One sentence of what GDAL said last.
  [[nodiscard]] std::string reason() const;

 private:
  GdalRaster(std::string path, const GdalLibrary* gdal, std::uint64_t n_file_bytes)
      : path_(std::move(path)), gdal_(gdal), n_file_bytes_(n_file_bytes) {}

  /// Of degrees, with the vertical part of the source's.
  [[nodiscard]] Result<std::string> crs_of_degrees() const;
  /// What warping the source to a virtual raster makes of it.
  [[nodiscard]] Result<void> warp_source(std::vector<std::string> words);
  [[nodiscard]] Result<void> check_size_in_degrees(const HeightReadOptions& options) const;
  /// Opens what check_virtual_raster() makes of it.
  [[nodiscard]] Result<void> open_virtual();
  /// Opens what import_raster() makes of it.
  [[nodiscard]] Result<void> open_imported(const HeightReadOptions& options, Progress& progress);
  /// The places of its samples.
  [[nodiscard]] Result<HeightFrame> frame_in_degrees() const;

  std::string path_;
  const GdalLibrary* gdal_;
  GDALDatasetH dataset_ = nullptr;
  GDALDatasetH source_ = nullptr;  ///< What was put in degrees.
  std::vector<RimHeight> rim_;
  std::string stated_crs_;  ///< Of a file that has none.
  bool is_virtual_ = false;
  std::vector<std::string> band_faults_{};  ///< CheckedVirtualRaster's.
  std::int32_t n_part_block_rows_ = 1;
  std::optional<ImportedRaster> imported_{};
  std::uint64_t n_file_bytes_;
};

}  // namespace lode::io
