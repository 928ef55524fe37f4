#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/spool_file.h"

namespace lode::io {

/// Whether a file starts as those of netCDF's classic formats do, or as HDF5, which netCDF-4 is.
[[nodiscard]] bool is_netcdf(const std::string& path);

/// Whether a file's name is that of a format that GDAL is asked for in a process apart, as its
/// drivers are rare and many: .ntf, .nitf, .gpkg, .grb, .grib, .grb2, .grib2, .adf, .ers, .rst,
/// .gtx, .lcp, .ter, .hfz, .map, .mpr, .cub, .lbl, .sigdem, .blx, .isg, .kro, .asc.gz,
/// .dem.gz and .tif.gz (any case).
[[nodiscard]] bool is_imported_path(const std::string& path);

/// What is wanted of a file.
struct ImportChoice {
  std::string variable{};         ///< Of netCDF; empty: the only one over two dimensions.
  std::optional<int> layer{};     ///< From 1; none: the only one, or the first band.
  bool crs_is_stated = false;     ///< Then what it says of its CRS need not be understood.
  bool nodata_is_stated = false;  ///< Then what it says of missing samples does not count.
};

/// The program that reads it, and how long it may say nothing.
struct ImportProgram {
  std::string path{};  ///< Empty: lode-raster-import beside this program or in PATH.
  std::chrono::milliseconds patience = std::chrono::seconds(60);
};

/// A raster of such a file as an uncompressed GeoTIFF that has no name, in TMPDIR: it is gone
/// when this or the process is.
struct ImportedRaster {
  SpoolFile copy;
  std::string format = "netCDF";     ///< Of the file.
  std::string crs{};                 ///< As WKT, which the copy may lack; empty: not known.
  bool is_in_plain_degrees = false;  ///< Longitudes and latitudes, of which the file says no more.
  bool is_of_points = false;         ///< Samples are at places, not of cells.
  std::vector<std::string> notes{};

  /// How GDAL opens the copy.
  [[nodiscard]] std::string name() const;
};

/// Has another process read it, as the libraries for it may crash, hang or ask for any memory over
/// a file that is damaged: that becomes an error here. It has 2 GiB of memory, and is ended where
/// it says nothing for a minute, or when this is cancelled. Fails, naming `path`, on files that
/// name others, on several variables or layers of netCDF of which none was chosen, on places that
/// are uneven, and where the directory has no room for the copy.
[[nodiscard]] Result<ImportedRaster> import_raster(const std::string& path,
                                                   const ImportChoice& choice, Progress& progress,
                                                   const ImportProgram& program = {});

}  // namespace lode::io
