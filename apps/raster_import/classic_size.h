#pragma once

#include <string>

namespace lode::raster_import {

/// Of a file in one of netCDF's classic formats (CDF-1, -2 and -5, by the NetCDF Classic Format
/// Specification): throws std::runtime_error where its header is damaged, or says more than the
/// file has, of which libnetcdf makes zeros.
void check_classic_size(const std::string& path);

}  // namespace lode::raster_import
