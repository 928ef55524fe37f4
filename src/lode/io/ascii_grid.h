#pragma once

#include <string>

namespace lode::io {

/// The type that holds the samples of an ESRI ASCII grid, whose text is read once: "Float64" where
/// a number with more than 7 digits, or of a size, is none of float32; "Float32" where all others
/// are and some are no whole ones; empty where GDAL is to choose, and for files of other formats.
/// GDAL looks at the beginning only, and takes no more than float32 unless asked.
[[nodiscard]] std::string ascii_grid_type(const std::string& path);

/// Whether a number that stands for no height in such a grid is none of float32, or one of those
/// beyond all heights, so that samples may say the same float in other digits.
[[nodiscard]] bool stands_for_float(double nodata);

}  // namespace lode::io
