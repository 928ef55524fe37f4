#pragma once

#include <cstdint>
#include <string>

#include "lode/core/result.h"
#include "lode/io/input_file.h"

namespace lode::io {

/// Where the variable length records of a LAS file are.
struct LasRecords {
  std::uint64_t first = 0;
  std::uint32_t n = 0;
  std::uint64_t end = 0;             ///< Where the points begin.
  std::uint64_t first_extended = 0;  ///< Of LAS 1.4, behind the points.
  std::uint32_t n_extended = 0;
};

struct LasCrs {
  std::string wkt;            ///< Empty: not known.
  std::string note;           ///< Why, where the file says something of it; else empty.
  std::string vertical_unit;  ///< Empty: not known.
};

enum class LasCrsUse : std::uint8_t { wanted, ignored };

/// The CRS of a LAS file: that of its WKT record, else of an EPSG code among its GeoTIFF keys, for
/// which GDAL is asked. `ignored`: only the vertical unit. Fails, naming file and offset, on
/// records that do not fit before the points.
[[nodiscard]] Result<LasCrs> read_las_crs(const InputFile& file, const LasRecords& records,
                                          LasCrsUse use);

}  // namespace lode::io
