#pragma once

#include <cmath>
#include <fstream>
#include <string>

namespace lode::test {

/// 40 x 30 heights in ESRI ASCII, one of them missing.
inline void write_dem(const std::string& path, int n_columns = 40, int n_rows = 30) {
  std::ofstream file(path);
  file << "ncols " << n_columns << "\nnrows " << n_rows
       << "\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\nnodata_value -9999\n";
  for (int y = 0; y < n_rows; ++y)
    for (int x = 0; x < n_columns; ++x)
      file << (x == 7 && y == 9 ? -9999
                                : std::lround(900 + 300 * std::sin(0.2 * x) * std::cos(0.3 * y)))
           << (x + 1 < n_columns ? ' ' : '\n');
}

/// A CRS beside it, as dem.prj beside dem.asc, which GDAL reads.
inline void write_dem_crs(const std::string& path) {
  std::ofstream(path) << R"(PROJCS["WGS 84 / UTM zone 11N",GEOGCS["WGS 84",)"
                         R"(DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
                         R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
                         R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
                         R"(PARAMETER["central_meridian",-117],PARAMETER["scale_factor",0.9996],)"
                         R"(PARAMETER["false_easting",500000],PARAMETER["false_northing",0],)"
                         R"(UNIT["metre",1]])";
}

}  // namespace lode::test
