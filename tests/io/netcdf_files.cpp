#include "tests/io/netcdf_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace lode::io::test {
namespace {

void expect_done(int status) { ASSERT_EQ(status, NC_NOERR) << nc_strerror(status); }

int define_axis(int file, const std::string& name, const std::string& units, nc_type type,
                int dimension) {
  int variable = -1;
  expect_done(nc_def_var(file, name.c_str(), type, 1, &dimension, &variable));
  if (!units.empty()) set_text(file, variable, "units", units);
  return variable;
}

}  // namespace

void write_netcdf_file(const std::string& path, const NetcdfFile& written) {
  int file = -1;
  expect_done(nc_create(path.c_str(), NC_CLOBBER | written.format, &file));
  std::vector<int> dimensions;
  if (written.n_layers > 0) {
    dimensions.push_back(-1);
    expect_done(nc_def_dim(file, "time", NC_UNLIMITED, &dimensions.back()));
  }
  int rows = -1;
  int columns = -1;
  expect_done(
      nc_def_dim(file, written.y_name.c_str(), static_cast<std::size_t>(written.n_rows), &rows));
  expect_done(nc_def_dim(file, written.x_name.c_str(), static_cast<std::size_t>(written.n_columns),
                         &columns));
  dimensions.insert(dimensions.end(), {rows, columns});
  int x = -1;
  int y = -1;
  if (!written.y.empty())
    y = define_axis(file, written.y_name, written.y_units, written.place_type, rows);
  if (!written.x.empty())
    x = define_axis(file, written.x_name, written.x_units, written.place_type, columns);
  int variable = -1;
  expect_done(nc_def_var(file, written.variable.c_str(), written.type,
                         static_cast<int>(dimensions.size()), dimensions.data(), &variable));
  if (!written.chunk.empty()) {
    std::vector<std::size_t> chunk(written.chunk.begin(), written.chunk.end());
    if (written.n_layers > 0) chunk.insert(chunk.begin(), 1);
    expect_done(nc_def_var_chunking(file, variable, NC_CHUNKED, chunk.data()));
    expect_done(nc_def_var_deflate(file, variable, 1, 1, 4));
  }
  if (written.define) written.define(file, variable);
  expect_done(nc_enddef(file));
  if (y >= 0) expect_done(nc_put_var_double(file, y, written.y.data()));
  if (x >= 0) expect_done(nc_put_var_double(file, x, written.x.data()));
  const auto n_columns = static_cast<std::size_t>(written.n_columns);
  const auto n_rows = static_cast<std::size_t>(written.n_rows);
  const std::array<std::size_t, 3> start{0, 0, 0};
  const std::array<std::size_t, 3> count{static_cast<std::size_t>(std::max(1, written.n_layers)),
                                         n_rows, n_columns};
  const std::size_t skipped = written.n_layers > 0 ? 0 : 1;
  if (!written.samples.empty())
    expect_done(nc_put_vara_double(file, variable, start.data() + skipped, count.data() + skipped,
                                   written.samples.data()));
  if (written.add) written.add(file, variable);
  expect_done(nc_close(file));
}

std::vector<double> places(double first, double step, int n) {
  std::vector<double> made;
  for (int i = 0; i < n; ++i) made.push_back(first + i * step);
  return made;
}

void set_number(int file, int variable, const char* name, nc_type type, double number) {
  expect_done(nc_put_att_double(file, variable, name, type, 1, &number));
}

void set_text(int file, int variable, const char* name, const std::string& text) {
  expect_done(nc_put_att_text(file, variable, name, text.size(), text.c_str()));
}

}  // namespace lode::io::test
