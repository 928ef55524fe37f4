#pragma once

#include <span>
#include <string>

#include "lode/core/result.h"

namespace lode::io {

/// GDAL's drivers that are asked of a file, and a null: those that read one file, or it and
/// sidecars of its name and kind, whatever it is called and says; neither others nor the network.
[[nodiscard]] std::span<const char* const> raster_drivers(const std::string& path);

/// Those, in words.
inline constexpr const char* kRasterFormats =
    "a GeoTIFF, PNG, DTED, USGS DEM, ESRI ASCII, EHdr, ENVI, ERDAS Imagine, JPEG 2000, SAGA, "
    "Surfer, BT or netCDF raster";

/// Refuses, saying why, what names other files: VRT, and netCDF-4, which is HDF5.
[[nodiscard]] Result<void> check_reads_itself(const std::string& path);

/// Whether a file is a raster of heights. By its name: .tif, .tiff, .asc, .hgt, .hgt.gz, .png,
/// .dem, .bil, .flt, .dt0, .dt1, .dt2, .jp2, .sdat, .nc, .grd, .bt, and .vrt, which is refused as
/// it is read (any case). By name and content: .img of ERDAS, and .img, .dat, .bip and .bsq beside
/// a header of ENVI. By content alone: a TIFF whose name says nothing else.
[[nodiscard]] bool is_height_path(const std::string& path);

}  // namespace lode::io
