#pragma once

#include <netcdf.h>

#include <cstddef>
#include <string>
#include <vector>

namespace lode::raster_import {

/// Throws std::runtime_error with what libnetcdf says of a status, or std::bad_alloc.
void check(int status, const std::string& what);

/// A netCDF file open for reading. All functions of this header throw std::runtime_error.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::string& path);
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;
  ~NetcdfFile();

  [[nodiscard]] int root() const { return id_; }

 private:
  int id_ = -1;
};

/// A variable of a group, whose id says of which file.
struct Variable {
  int group = -1;
  int id = -1;
  std::string name{};  ///< With the groups that it is in: "deep/z".
  nc_type type = NC_NAT;
  std::vector<int> dimensions{};  ///< The last one varies fastest.

  [[nodiscard]] std::size_t rank() const { return dimensions.size(); }
};

/// All variables, in the order of the file, those of a group before those of its groups.
[[nodiscard]] std::vector<Variable> all_variables(int root);

[[nodiscard]] std::size_t length_of(int group, int dimension);
[[nodiscard]] std::string dimension_name(int group, int dimension);

/// The type and number of values of an attribute; NC_NAT where there is none. `variable` may be
/// NC_GLOBAL.
struct AttributeShape {
  nc_type type = NC_NAT;
  std::size_t n = 0;

  [[nodiscard]] bool is_text() const { return type == NC_CHAR || type == NC_STRING; }
};
[[nodiscard]] AttributeShape attribute_shape(int group, int variable, const char* name);

/// An attribute as text, without blanks round it; empty where there is none or it is of numbers.
[[nodiscard]] std::string text_attribute(int group, int variable, const char* name);
/// As numbers; empty where there is none. Fails on text.
[[nodiscard]] std::vector<double> numbers_attribute(int group, int variable, const char* name);

}  // namespace lode::raster_import
