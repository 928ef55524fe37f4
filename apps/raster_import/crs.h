#pragma once

#include <string>

#include "netcdf_file.h"

namespace lode::raster_import {

/// What a variable's grid_mapping says, as WKT; empty where it has none.
struct GridMapping {
  std::string wkt;
  double metres_a_unit = 1;  ///< Of x and y; of degrees 1.
  bool is_geographic = false;
};

/// From crs_wkt, spatial_ref or epsg_code where they are there, else by GDAL from CF's attributes.
/// Throws std::runtime_error where that is not understood. The variable's last two dimensions have
/// coordinates.
[[nodiscard]] GridMapping read_grid_mapping(const Variable& variable);

}  // namespace lode::raster_import
