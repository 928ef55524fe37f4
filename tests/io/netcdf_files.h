#pragma once

#include <netcdf.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace lode::io::test {

/// A netCDF file to be written, with libnetcdf: a writer of ours would show little.
struct NetcdfFile {
  int format = NC_NETCDF4;  ///< Or 0 (classic), NC_64BIT_OFFSET, NC_64BIT_DATA.
  int n_columns = 4;
  int n_rows = 3;
  nc_type type = NC_SHORT;
  std::vector<double> samples{};  ///< In rows, as they lie in the file; of all layers.
  std::vector<double> x{};        ///< Empty: no coordinates.
  std::vector<double> y{};
  nc_type place_type = NC_DOUBLE;
  std::string x_name = "lon";
  std::string y_name = "lat";
  std::string x_units = "degrees_east";
  std::string y_units = "degrees_north";
  std::string variable = "z";
  int n_layers = 0;          ///< Along "time", which is unlimited; 0: there is none.
  std::vector<int> chunk{};  ///< Rows and columns, deflated; empty: whole.
  /// Called before samples are written, with the file and the variable.
  std::function<void(int file, int variable)> define{};
  /// Called after they were.
  std::function<void(int file, int variable)> add{};
};

void write_netcdf_file(const std::string& path, const NetcdfFile& file);

/// `n` of them.
[[nodiscard]] std::vector<double> places(double first, double step, int n);

/// For NetcdfFile::define: an attribute of one number of a type, and of text.
void set_number(int file, int variable, const char* name, nc_type type, double number);
void set_text(int file, int variable, const char* name, const std::string& text);

}  // namespace lode::io::test
