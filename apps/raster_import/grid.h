#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "axes.h"
#include "netcdf_file.h"

namespace lode::raster_import {

/// What is to be read of a file.
struct Choice {
  std::string variable;              ///< Empty: the only one.
  std::optional<std::size_t> layer;  ///< From 1, of what lies along dimensions but the last two.
  bool crs_is_stated = false;        ///< Then a grid mapping that is not understood will do.
  bool nodata_is_stated = false;     ///< Then what the file says of missing numbers counts not.
};

/// A raster within a file.
struct Grid {
  Variable variable;
  std::vector<std::size_t> start;  ///< Of its first sample, by dimension.
  Axis columns;
  Axis rows;
  std::string crs;                   ///< As WKT; empty: not known.
  bool is_in_plain_degrees = false;  ///< Longitudes and latitudes, of which it says no more.
  std::vector<std::string> notes;    ///< What is taken for something that the file does not say.
  std::optional<bool> is_point;  ///< Samples are at places, not of cells; none: it does not say.
};

/// Chooses a variable over two dimensions or more, whose last two are rows and columns. Throws
/// std::runtime_error, with the names of what there is, where there are none or several, or where
/// places are not those of a raster.
[[nodiscard]] Grid find_grid(int root, const Choice& choice);

}  // namespace lode::raster_import
