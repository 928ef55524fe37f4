#pragma once

#include <gdal.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace lode::io::test {

/// A raster to be written, with GDAL's own library: a writer of ours would show little.
struct RasterFile {
  int n_columns = 4;
  int n_rows = 3;
  GDALDataType type = GDT_Int16;
  std::vector<double> samples{};  ///< Of the first band, in rows; further bands add 1000 each.
  int n_bands = 1;
  std::optional<std::array<double, 6>> geotransform{};
  std::optional<double> nodata{};
  int epsg = 0;
  std::string crs{};  ///< As OSRSetFromUserInput() takes it, instead.
  double scale = 1;
  double offset = 0;
  std::string unit{};
  bool is_point = false;  ///< AREA_OR_POINT=Point
  bool is_compressed = false;
  bool is_signed_byte = false;          ///< Of Byte, as GDAL before 3.7 writes int8.
  std::optional<std::int64_t> int64{};  ///< Of GDT_Int64: the first sample instead.
  std::optional<std::int64_t> nodata64{};
};

/// Writes it as `driver`, GTiff or what can be copied from one (AAIGrid, PNG, HFA, ...).
void write_raster(const std::string& path, const RasterFile& raster, const char* driver = "GTiff");

}  // namespace lode::io::test
