// The program on rasters of netCDF: what it makes of them is what it makes of GeoTIFF.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/cli/program.h"
#include "tests/io/height_files.h"
#include "tests/io/netcdf_files.h"

namespace lode::test {
namespace {

using io::test::NetcdfFile;
using io::test::places;
using io::test::RasterFile;
using io::test::write_netcdf_file;
using io::test::write_raster;

constexpr int kColumns = 61;
constexpr int kRows = 47;

double hill(int column, int row) {
  return std::round(400 * std::sin(0.13 * column) * std::cos(0.17 * row) + 3 * column);
}

/// The same hills from north to south, and as GMT writes them, from south to north.
class netcdf : public testing::Test {
 protected:
  netcdf() {
    std::filesystem::create_directory(scratch_ / "tmp");
    ::setenv("TMPDIR", (scratch_ / "tmp").c_str(), 1);
    RasterFile tiff{.n_columns = kColumns, .n_rows = kRows, .epsg = 4326, .unit = "m"};
    tiff.geotransform = {7.875, 0.25, 0, 51.625, 0, -0.25};
    NetcdfFile file{.n_columns = kColumns, .n_rows = kRows, .chunk = {16, 16}};
    file.x = places(8, 0.25, kColumns);
    file.y = places(40, 0.25, kRows);
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column) {
        tiff.samples.push_back(hill(column, row));
        file.samples.push_back(hill(column, kRows - 1 - row));
      }
    tiff.nodata = file.samples[5] = tiff.samples[std::size_t{kRows - 1} * kColumns + 5] = -32768;
    file.define = [](int nc, int z) {
      io::test::set_text(nc, z, "units", "m");
      io::test::set_number(nc, z, "_FillValue", NC_SHORT, -32768);
    };
    write_raster(scratch_ / "a.tif", tiff);
    write_netcdf_file(scratch_ / "a.nc", file);
    // Of a time, and beside another variable.
    file.n_layers = 2;
    file.samples.insert(file.samples.end(), file.samples.begin(), file.samples.end());
    for (std::size_t i = 0; i < file.samples.size() / 2; ++i) file.samples[i] = 1;
    file.add = [](int nc, int z) {
      int dimensions[3] = {};
      int other = -1;
      nc_inq_vardimid(nc, z, dimensions);
      nc_redef(nc);
      nc_def_var(nc, "other", NC_SHORT, 2, dimensions + 1, &other);
      nc_enddef(nc);
    };
    write_netcdf_file(scratch_ / "times.nc", file);
  }
  ~netcdf() override {
    EXPECT_TRUE(std::filesystem::is_empty(scratch_ / "tmp")) << "copies are gone";
    ::unsetenv("TMPDIR");
  }
  [[nodiscard]] std::string bytes_of(const Words& words, const std::string& output) const {
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_bytes(scratch_ / output);
  }

  Scratch scratch_;
};

TEST_F(netcdf, makes_the_meshes_lines_and_files_that_geotiff_does) {
  const std::vector<std::pair<Words, std::string>> commands{
      {{"extract", "--max-error", "20"}, "mesh.ply"},
      {{"extract", "--max-error", "20"}, "mesh.tif"},
      {{"contours", "--interval", "100"}, "lines.geojson"},
      {{"build", "--model", "delaunay_pyramid"}, "built.lode"},
      {{"build", "--model", "right_triangle_bisection"}, "bisected.lode"}};
  for (const auto& [options, output] : commands) {
    const auto made_of = [&, &words = options, &out = output](const std::string& input) {
      Words all{words.front(), scratch_ / input, scratch_ / out};
      all.insert(all.end(), words.begin() + 1, words.end());
      const std::string bytes = bytes_of(all, out);
      std::filesystem::remove(scratch_ / out);
      return bytes;
    };
    const std::string expected = made_of("a.tif");
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(expected == made_of("a.nc")) << output;
  }
}

TEST_F(netcdf, is_taken_by_every_command_on_rasters) {
  const std::string in = scratch_ / "a.nc";
  const std::vector<Words> commands{
      {"info", in},
      {"height", in, "--at", "10,45", "--at", "12.5,44"},
      {"profile", in, "--from", "9,41", "--to", "20,50"},
      {"sight", in, "--from", "9,41", "--to", "20,50"},
      {"features", in, scratch_ / "peaks.geojson"},
      {"render", in, scratch_ / "a.png", "--size", "64x48"},
      {"tiles", in, scratch_ / "tiles", "--max-error", "50"},
      {"compare", in, scratch_ / "report.html", "--tolerances", "50", "--runs", "1"},
      {"verify", in, "--surface", scratch_ / "mesh.ply", "--max-error", "20"}};
  EXPECT_EQ(run_lode({"extract", in, scratch_ / "mesh.ply", "--max-error", "20"}).exit_code, 0);
  for (const Words& words : commands) {
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << words.front() << ": " << run.err;
    EXPECT_NE(run.err.find("taken for those of WGS 84"), std::string::npos) << words.front();
  }
}

TEST_F(netcdf, is_described) {
  const Finished run = run_lode({"info", scratch_ / "a.nc", "--json"});
  const nlohmann::json ours = run.json();
  const nlohmann::json theirs = run_lode({"info", scratch_ / "a.tif", "--json"}).json();
  EXPECT_EQ(ours.at("format"), "netCDF");
  EXPECT_NE(run.err.find("a.nc: its longitudes and latitudes are taken"), std::string::npos);
  for (const char* key : {"range", "cells", "left_out_samples", "type", "vertical_unit", "crs"})
    if (theirs.contains(key)) EXPECT_EQ(ours.at(key), theirs.at(key)) << key;
}

TEST_F(netcdf, is_of_the_variable_and_layer_that_are_named) {
  const std::string in = scratch_ / "times.nc";
  expect_refusal(run_lode({"info", in}), 1, {"times.nc", "--variable", "z, other"});
  expect_refusal(run_lode({"info", in, "--variable", "z"}), 1,
                 {"times.nc", "--band 1 to 2", "along time"});
  expect_refusal(run_lode({"info", in, "--variable", "y"}), 1, {"a variable 'y'"});
  const Words wanted{"--variable", "z", "--band", "2", "--max-error", "20"};
  const auto extracted = [&](Words words) {
    words.insert(words.end(), wanted.begin() + (words[1] == in ? 0 : 4), wanted.end());
    return bytes_of(words, "mesh.ply");
  };
  const std::string expected = extracted({"extract", scratch_ / "a.tif", scratch_ / "mesh.ply"});
  EXPECT_TRUE(expected == extracted({"extract", in, scratch_ / "mesh.ply"}));
  expect_refusal(run_lode({"info", scratch_ / "a.tif", "--variable", "z"}), 1,
                 {"a.tif", "expected a netCDF file"});
  write_bytes(scratch_ / "a.xyz", "0 0 1\n1 0 1\n0 1 1\n");
  expect_refusal(
      run_lode({"extract", scratch_ / "a.xyz", scratch_ / "mesh.ply", "--variable", "z"}), 2,
      {"a.xyz", "--variable"});
}

TEST_F(netcdf, that_is_damaged_is_an_error_of_one_line) {
  const std::string whole = read_bytes(scratch_ / "a.nc");
  write_bytes(scratch_ / "short.nc", whole.substr(0, whole.size() / 2));
  expect_refusal(run_lode({"info", scratch_ / "short.nc"}), 1, {"short.nc", "that is whole"});
  write_bytes(scratch_ / "head.grd", "CDF\1 and more");
  expect_refusal(run_lode({"extract", scratch_ / "head.grd", scratch_ / "mesh.ply"}), 1,
                 {"head.grd", "that is whole"});
}

TEST_F(netcdf, needs_a_directory_for_its_copy) {
  ::setenv("TMPDIR", (scratch_ / "nowhere").c_str(), 1);
  expect_refusal(run_lode({"info", scratch_ / "a.nc"}), 1, {"a.nc", "TMPDIR"});
  ::setenv("TMPDIR", (scratch_ / "tmp").c_str(), 1);
}

}  // namespace
}  // namespace lode::test
