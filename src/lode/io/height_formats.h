#pragma once

#include <span>
#include <string>

#include "lode/core/result.h"

namespace lode::io {

/// GDAL's drivers that are asked, and a null: those that read one file, or it and
/// sidecars of its name and kind, whatever it is called and says; neither others nor the network.
/// VRT, which reads others, is asked where these have been looked at: check_virtual_raster().
[[nodiscard]] std::span<const char* const> raster_drivers();
/// Of parts of a VRT: those, and SRTM's .hgt, which is read without GDAL otherwise.
[[nodiscard]] std::span<const char* const> part_drivers();

/// Those, in words.
inline constexpr const char* kRasterFormats =
    "a GeoTIFF, PNG, DTED, USGS DEM, ESRI ASCII, EHdr, ENVI, ERDAS Imagine, JPEG 2000, SAGA, "
    "Surfer or BT raster, a VRT of those, or netCDF";

/// Of what GDAL is to open in this process: refuses, saying why, netCDF, which as HDF5 may name
/// other files, and of which GDAL's driver does not survive damaged ones (imported_raster.h reads
/// it); and SAGA grids whose heights are a multiple of what they store, which GDAL does not heed.
[[nodiscard]] Result<void> check_raster_kind(const std::string& path);

/// Whether a file is a raster of heights. By its name: .tif, .tiff, .asc, .hgt, .hgt.gz, .png,
/// .dem, .bil, .flt, .dt0, .dt1, .dt2, .jp2, .sdat, .grd, .bt, .vrt, .nc, .nc4 and .cdf (any
/// case), and what is_imported_path() says. By name and content: .img of ERDAS, and .img, .dat,
/// .bip and .bsq beside a header of ENVI. By content alone: a TIFF, or netCDF, whose name says
/// nothing else.
[[nodiscard]] bool is_height_path(const std::string& path);

}  // namespace lode::io
