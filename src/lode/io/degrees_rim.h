#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/io/height_reader.h"

namespace lode::io {

class GdalRaster;

/// One of a file's outermost samples, with a height.
struct BorderHeight {
  Vec<double, 2> place;  ///< Of the file's CRS, or where it is brought to.
  double height = 0;
};

/// A sample of a raster in degrees that pixels of the file do not reach, in a cell with one of its
/// outermost samples, whose height it gets.
struct RimHeight {
  std::int32_t row = 0;
  std::int32_t column = 0;
  double height = 0;
};

/// Reads a file's samples in their own CRS, which it is not yet put out of, in strips, and keeps
/// the outermost ones. Fails as reading does.
[[nodiscard]] Result<std::vector<BorderHeight>> read_border(const GdalRaster& raster,
                                                            const HeightReadOptions& options);

/// The columns and rows of places in degrees, in a raster there. Places that degrees have not are
/// left out.
[[nodiscard]] Result<std::vector<BorderHeight>> border_in_degrees(const std::string& path,
                                                                  const std::string& file_crs,
                                                                  const HeightFrame& degrees,
                                                                  std::vector<BorderHeight> border);

/// How many columns and rows a raster lacks before and behind it, that all places lie between
/// samples of it: of columns, then of rows.
[[nodiscard]] std::array<std::array<std::int32_t, 2>, 2> lacking(
    const HeightFrame& degrees, const std::vector<BorderHeight>& border);

/// The corners of the cells that outermost samples lie in, by row and column, each with the height
/// of the nearest of these.
[[nodiscard]] std::vector<RimHeight> find_rim(const HeightFrame& degrees,
                                              const std::vector<BorderHeight>& border);

}  // namespace lode::io
