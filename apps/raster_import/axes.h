#pragma once

#include <cstddef>
#include <string>

#include "netcdf_file.h"

namespace lode::raster_import {

enum class AxisKind { longitude, latitude, x, y, unknown };

/// A dimension of a raster with the places of its samples, which are a step apart.
struct Axis {
  AxisKind kind = AxisKind::unknown;
  std::string name;
  std::size_t n = 0;
  bool has_places = false;  ///< Else first and step mean nothing.
  double first = 0;         ///< Of samples, not of the edges of cells.
  double step = 0;          ///< Negative where places fall.
  std::string units;        ///< As the file says them.
};

/// The coordinate variable of a dimension, by name, in a group or those it is in, or the only one
/// of the group that has longitudes or latitudes along it; id -1: none.
[[nodiscard]] Variable coordinate_of(int group, int dimension);

/// Throws std::runtime_error where places are uneven by more than a hundredth of a step, or by what
/// float32 rounds, or are of fewer than two samples.
[[nodiscard]] Axis read_axis(int group, int dimension);

/// Whether columns run along x and rows along y, as far as a file says.
[[nodiscard]] bool is_crossed(const Axis& columns, const Axis& rows);

}  // namespace lode::raster_import
