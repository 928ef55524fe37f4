#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "netcdf_file.h"

namespace lode::raster_import {

/// How stored numbers become heights: number * scale + offset.
struct Packing {
  double scale = 1;
  double offset = 0;
};
[[nodiscard]] Packing read_packing(const Variable& variable);

/// Whether a variable's integers are to be taken as unsigned ones, as classic formats have none.
[[nodiscard]] bool is_marked_unsigned(const Variable& variable);

/// Which numbers of type T stand for none: the netCDF Users' Guide's _FillValue, missing_value,
/// valid_min, valid_max and valid_range, and of types of two bytes or more what libnetcdf fills
/// variables with that say nothing.
template <typename T>
struct Missing {
  std::optional<T> nodata{};  ///< What others become; none: all count.
  std::vector<T> others{};
  std::optional<double> least{};  ///< As numbers are stored, and rounded as T is.
  std::optional<double> most{};

  [[nodiscard]] bool is_plain() const { return others.empty() && !least && !most; }
  [[nodiscard]] bool is_other(T value) const {
    for (const T other : others)
      if (value == other) return true;
    const auto number = static_cast<double>(value);
    return (least && number < *least) || (most && number > *most);
  }
};

/// Throws std::runtime_error where attributes are no numbers.
template <typename T>
[[nodiscard]] Missing<T> read_missing(const Variable& variable);

}  // namespace lode::raster_import
