#include "grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "crs.h"

namespace lode::raster_import {
namespace {

constexpr std::size_t kMostShown = 20;

bool is_of_numbers(const Variable& variable) {
  return variable.type != NC_CHAR && variable.type >= NC_BYTE && variable.type <= NC_UINT64;
}

int dimension_of_columns(const Variable& variable) { return variable.dimensions.back(); }
int dimension_of_rows(const Variable& variable) { return variable.dimensions[variable.rank() - 2]; }

bool has_coordinates(const Variable& variable) {
  return coordinate_of(variable.group, dimension_of_columns(variable)).id >= 0 &&
         coordinate_of(variable.group, dimension_of_rows(variable)).id >= 0;
}

/// Names of variables that say where others lie.
std::set<std::string> helpers_of(const std::vector<Variable>& all) {
  std::set<std::string> helpers;
  for (const Variable& variable : all)
    for (const char* attribute : {"bounds", "coordinates", "grid_mapping"}) {
      std::istringstream words(text_attribute(variable.group, variable.id, attribute));
      const std::string folder = variable.name.substr(0, variable.name.rfind('/') + 1);
      for (std::string word; words >> word;) helpers.insert(folder + word);
    }
  return helpers;
}

std::vector<Variable> candidates_of(const std::vector<Variable>& all) {
  const std::set<std::string> helpers = helpers_of(all);
  std::vector<Variable> found;
  for (const Variable& one : all)
    if (is_of_numbers(one) && one.rank() >= 2 && !helpers.contains(one.name)) found.push_back(one);
  // Where some have places others are tables.
  if (std::any_of(found.begin(), found.end(), has_coordinates))
    std::erase_if(found, [](const Variable& one) { return !has_coordinates(one); });
  return found;
}

std::string names_of(const std::vector<Variable>& variables) {
  std::string names;
  for (std::size_t i = 0; i < std::min(variables.size(), kMostShown); ++i)
    names += (i == 0 ? "" : ", ") + variables[i].name;
  if (variables.size() > kMostShown)
    names += " and " + std::to_string(variables.size() - kMostShown) + " more";
  return names;
}

bool is_old_gmt(const std::vector<Variable>& all) {
  return std::any_of(all.begin(), all.end(), [](const Variable& one) {
    return one.name == "x_range" || one.name == "side";
  });
}

Variable choose_variable(int root, const std::string& wanted) {
  const std::vector<Variable> all = all_variables(root);
  const std::vector<Variable> candidates = candidates_of(all);
  if (!wanted.empty()) {
    const std::string name = wanted.starts_with('/') ? wanted.substr(1) : wanted;
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Variable& one) { return one.name == name; });
    if (found == all.end())
      throw std::runtime_error(
          "expected a variable '" + name + "', got " +
          (candidates.empty() ? "none over two dimensions" : names_of(candidates)));
    if (found->rank() >= 2 && is_of_numbers(*found)) return *found;
    throw std::runtime_error("expected a variable of numbers over two dimensions, got '" + name +
                             "', which is none");
  }
  if (candidates.size() == 1) return candidates.front();
  if (!candidates.empty())
    throw std::runtime_error("expected --variable, which of several is read: " +
                             names_of(candidates));
  if (is_old_gmt(all))
    throw std::runtime_error(
        "expected a variable over two dimensions, got a grid of GMT before version 4: gmt "
        "grdconvert makes a newer one of it");
  throw std::runtime_error("expected a variable of numbers over two dimensions, got none");
}

/// Where the samples of a layer begin.
std::vector<std::size_t> start_of(const Variable& variable, std::optional<std::size_t> layer) {
  constexpr std::size_t kMost = std::size_t{1} << 40;
  std::size_t n = 1;
  std::string along;
  for (std::size_t i = 0; i + 2 < variable.rank(); ++i) {
    const std::size_t length = length_of(variable.group, variable.dimensions[i]);
    if (length == 0 || n > kMost / length)
      throw std::runtime_error("expected layers of " + variable.name + ", got " +
                               std::to_string(length) + " along " +
                               dimension_name(variable.group, variable.dimensions[i]));
    n *= length;
    along += (i == 0 ? "" : ", ") + dimension_name(variable.group, variable.dimensions[i]);
  }
  if (n > 1 && !layer)
    throw std::runtime_error("expected --band 1 to " + std::to_string(n) + ", which layer of " +
                             variable.name + " along " + along + " is read, got none");
  if (layer.value_or(1) > n)
    throw std::runtime_error("expected a band from 1 to " + std::to_string(n) + ", got " +
                             std::to_string(*layer));
  std::vector<std::size_t> start(variable.rank(), 0);
  std::size_t rest = layer.value_or(1) - 1;
  for (std::size_t i = variable.rank() - 2; i-- > 0;) {
    const std::size_t length = length_of(variable.group, variable.dimensions[i]);
    start[i] = rest % length;
    rest /= length;
  }
  return start;
}

/// netCDF-4 is HDF5 whose dimensions have names; libnetcdf makes some up for others.
void check_dimensions(const Grid& grid) {
  constexpr std::string_view kMadeUp = "phony_dim_";
  if (!grid.columns.name.starts_with(kMadeUp) && !grid.rows.name.starts_with(kMadeUp)) return;
  throw std::runtime_error("expected netCDF-4, got HDF5 whose dimensions have no names, as of " +
                           grid.variable.name);
}

void check_places(const Grid& grid) {
  const Variable& variable = grid.variable;
  if (grid.columns.has_places != grid.rows.has_places)
    throw std::runtime_error("expected places along " + grid.rows.name + " and " +
                             grid.columns.name + " or along none, got them along one");
  if (is_crossed(grid.columns, grid.rows))
    throw std::runtime_error("expected a variable over y and x, whose columns run along x, got " +
                             variable.name + " over " + grid.rows.name + " and " +
                             grid.columns.name);
  const std::string places = text_attribute(variable.group, variable.id, "coordinates");
  if (!grid.columns.has_places && !places.empty())
    throw std::runtime_error("expected places along " + grid.rows.name + " and " +
                             grid.columns.name + ", got a place of each sample, in " + places);
}

/// Of x and y as files say it; none of others, which are taken for the CRS's own.
std::optional<double> metres_of(const std::string& units) {
  constexpr std::array<std::string_view, 5> kMetres{"m", "metre", "metres", "meter", "meters"};
  constexpr std::array<std::string_view, 5> kThousands{"km", "kilometre", "kilometres", "kilometer",
                                                       "kilometers"};
  if (std::find(kMetres.begin(), kMetres.end(), units) != kMetres.end()) return 1;
  if (std::find(kThousands.begin(), kThousands.end(), units) != kThousands.end()) return 1000;
  return {};
}

void put_in_units(const GridMapping& mapping, Axis& axis) {
  const auto metres = metres_of(axis.units);
  if (mapping.is_geographic || !metres || *metres == mapping.metres_a_unit) return;
  axis.first *= *metres / mapping.metres_a_unit;
  axis.step *= *metres / mapping.metres_a_unit;
}

/// Throws where places are not what the mapping is of.
void check_mapping(const GridMapping& mapping, const Axis& axis) {
  const bool is_of_degrees = axis.kind == AxisKind::longitude || axis.kind == AxisKind::latitude;
  if (!mapping.is_geographic && is_of_degrees)
    throw std::runtime_error("expected lengths of the projection along " + axis.name +
                             ", got longitudes or latitudes");
  if (mapping.is_geographic && metres_of(axis.units))
    throw std::runtime_error("expected degrees along " + axis.name + ", got " + axis.units);
}

/// Of no CRS, or one that is stated elsewhere.
void put_in_metres(Axis& axis, std::vector<std::string>& notes) {
  const double metres = metres_of(axis.units).value_or(1);
  if (metres == 1) return;
  axis.first *= metres;
  axis.step *= metres;
  notes.push_back("its places along " + axis.name + " are in " + axis.units +
                  ", and are turned into metres");
}

void note_what_is_taken(Grid& grid) {
  if (!grid.columns.has_places) {
    grid.notes.push_back(
        "it does not say where its rows and columns lie: the first row is taken "
        "for the northern one");
    return;
  }
  if (grid.columns.kind == AxisKind::unknown && grid.rows.kind == AxisKind::unknown)
    grid.notes.push_back("it does not say which way its axes lead: " + grid.columns.name +
                         " is taken for x, and " + grid.rows.name + " for y");
}

void set_crs(const Choice& choice, Grid& grid) {
  if (!grid.columns.has_places) return;
  for (const Axis* axis : {&grid.columns, &grid.rows})
    if (axis->units == "rad" || axis->units == "radian" || axis->units == "radians")
      throw std::runtime_error("expected lengths or degrees along " + axis->name +
                               ", got angles of a satellite");
  GridMapping mapping;
  try {
    mapping = read_grid_mapping(grid.variable);
  } catch (const std::runtime_error&) {
    if (!choice.crs_is_stated) throw;
  }
  grid.crs = mapping.wkt;
  grid.is_in_plain_degrees = mapping.wkt.empty() && grid.columns.kind == AxisKind::longitude &&
                             grid.rows.kind == AxisKind::latitude;
  if (mapping.wkt.empty()) {
    put_in_metres(grid.columns, grid.notes);
    put_in_metres(grid.rows, grid.notes);
    return;
  }
  check_mapping(mapping, grid.columns);
  check_mapping(mapping, grid.rows);
  put_in_units(mapping, grid.columns);
  put_in_units(mapping, grid.rows);
}

}  // namespace

Grid find_grid(int root, const Choice& choice) {
  Grid grid;
  grid.variable = choose_variable(root, choice.variable);
  grid.start = start_of(grid.variable, choice.layer);
  grid.columns = read_axis(grid.variable.group, dimension_of_columns(grid.variable));
  grid.rows = read_axis(grid.variable.group, dimension_of_rows(grid.variable));
  check_dimensions(grid);
  check_places(grid);
  set_crs(choice, grid);
  note_what_is_taken(grid);
  // GMT's word for pixels; without it CF says where samples are, and not what they are of.
  const std::vector<double> offset = numbers_attribute(root, NC_GLOBAL, "node_offset");
  if (!offset.empty()) grid.is_point = offset.front() == 0;
  return grid;
}

}  // namespace lode::raster_import
