#include "axes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "missing.h"

namespace lode::raster_import {
namespace {

std::string in_small(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

template <std::size_t N>
bool is_any(const std::string& text, const std::array<std::string_view, N>& known) {
  return std::find(known.begin(), known.end(), text) != known.end();
}

/// CF tells longitudes and latitudes by their units; standard names, axes and names are used too.
AxisKind kind_of(const Variable& variable) {
  constexpr std::array<std::string_view, 6> kEast{"degrees_east", "degree_east", "degree_e",
                                                  "degrees_e",    "degreee",     "degreese"};
  constexpr std::array<std::string_view, 6> kNorth{"degrees_north", "degree_north", "degree_n",
                                                   "degrees_n",     "degreen",      "degreesn"};
  const auto text = [&](const char* name) {
    return in_small(text_attribute(variable.group, variable.id, name));
  };
  const std::string standard = text("standard_name");
  // Of a pole that is elsewhere.
  if (standard == "grid_longitude") return AxisKind::x;
  if (standard == "grid_latitude") return AxisKind::y;
  const std::string units = text("units");
  if (is_any(units, kEast) || standard == "longitude") return AxisKind::longitude;
  if (is_any(units, kNorth) || standard == "latitude") return AxisKind::latitude;
  const std::string name = in_small(variable.name.substr(variable.name.rfind('/') + 1));
  const bool may_be_degrees = units.empty() || units == "degrees" || units == "degree";
  if (may_be_degrees && (name == "lon" || name == "longitude")) return AxisKind::longitude;
  if (may_be_degrees && (name == "lat" || name == "latitude")) return AxisKind::latitude;
  const std::string axis = text("axis");
  if (axis == "x" || standard == "projection_x_coordinate" || name == "x" || name == "easting")
    return AxisKind::x;
  if (axis == "y" || standard == "projection_y_coordinate" || name == "y" || name == "northing")
    return AxisKind::y;
  return AxisKind::unknown;
}

/// A variable of numbers over that dimension alone; else its id is -1.
Variable one_along(int group, int id, int dimension) {
  int rank = 0;
  if (nc_inq_varndims(group, id, &rank) != NC_NOERR || rank != 1) return {};
  Variable found{.group = group, .id = id};
  found.dimensions.resize(1);
  std::array<char, NC_MAX_NAME + 1> name{};
  check(nc_inq_var(group, id, name.data(), &found.type, nullptr, found.dimensions.data(), nullptr),
        "a coordinate");
  found.name = name.data();
  const bool is_number = found.type != NC_CHAR && found.type <= NC_UINT64;
  return found.dimensions[0] == dimension && is_number ? found : Variable{};
}

std::string shown(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", number);
  return text.data();
}

void set_places(const Variable& variable, Axis& axis) {
  constexpr double kMostOff = 0.01;
  std::vector<double> places(axis.n);
  check(nc_get_var_double(variable.group, variable.id, places.data()), "places along " + axis.name);
  if (is_marked_unsigned(variable))
    throw std::runtime_error("expected places along " + axis.name +
                             ", got integers that are marked unsigned");
  const Packing packing = read_packing(variable);
  for (double& place : places) place = place * packing.scale + packing.offset;
  for (const double place : places)
    if (!std::isfinite(place))
      throw std::runtime_error("expected numbers for places along " + axis.name + ", got " +
                               shown(place));
  axis.first = places.front();
  axis.step = (places.back() - places.front()) / static_cast<double>(axis.n - 1);
  if (axis.step == 0 || !std::isfinite(axis.step))
    throw std::runtime_error("expected places along " + axis.name + " that differ, got " +
                             shown(places.front()) + " to " + shown(places.back()));
  double most_off = kMostOff * std::abs(axis.step);
  if (variable.type == NC_FLOAT) {
    const double largest = std::max(std::abs(places.front()), std::abs(places.back()));
    most_off = std::max(most_off, largest * std::numeric_limits<float>::epsilon());
  }
  // What float32 cannot tell apart is no raster.
  most_off = std::min(most_off, std::abs(axis.step) / 4);
  for (std::size_t i = 0; i < axis.n; ++i) {
    const double even = axis.first + static_cast<double>(i) * axis.step;
    if (std::abs(places[i] - even) > most_off)
      throw std::runtime_error("expected even places along " + axis.name + ", got " +
                               shown(places[i]) + " at " + std::to_string(i) + ", where steps of " +
                               shown(axis.step) + " lead to " + shown(even));
  }
  axis.has_places = true;
}

/// Of one name or another, longitudes or latitudes along a dimension: none where several are.
Variable degrees_along(int group, int dimension) {
  int n = 0;
  check(nc_inq_varids(group, &n, nullptr), "variables");
  std::vector<int> ids(static_cast<std::size_t>(n));
  check(nc_inq_varids(group, &n, ids.data()), "variables");
  Variable found;
  for (const int id : ids) {
    Variable one = one_along(group, id, dimension);
    const AxisKind kind = one.id < 0 ? AxisKind::unknown : kind_of(one);
    if (kind != AxisKind::longitude && kind != AxisKind::latitude) continue;
    if (found.id >= 0) return {};
    found = std::move(one);
  }
  return found;
}

bool is_northward(AxisKind kind) { return kind == AxisKind::latitude || kind == AxisKind::y; }
bool is_eastward(AxisKind kind) { return kind == AxisKind::longitude || kind == AxisKind::x; }

}  // namespace

Variable coordinate_of(int group, int dimension) {
  const std::string name = dimension_name(group, dimension);
  for (int at = group;;) {
    int id = 0;
    if (nc_inq_varid(at, name.c_str(), &id) == NC_NOERR) {
      Variable found = one_along(at, id, dimension);
      if (found.id >= 0) return found;
    }
    int parent = 0;
    if (nc_inq_grp_parent(at, &parent) != NC_NOERR) return degrees_along(group, dimension);
    at = parent;
  }
}

Axis read_axis(int group, int dimension) {
  Axis axis;
  axis.name = dimension_name(group, dimension);
  axis.n = length_of(group, dimension);
  if (axis.n < 2)
    throw std::runtime_error("expected two samples or more along " + axis.name + ", got " +
                             std::to_string(axis.n));
  const Variable variable = coordinate_of(group, dimension);
  if (variable.id < 0) return axis;
  axis.kind = kind_of(variable);
  axis.units = text_attribute(variable.group, variable.id, "units");
  set_places(variable, axis);
  return axis;
}

bool is_crossed(const Axis& columns, const Axis& rows) {
  return is_northward(columns.kind) || is_eastward(rows.kind);
}

}  // namespace lode::raster_import
