// Rasters in formats that GDAL is asked for in a process apart: heights, places and CRS are what
// was written, and what is no raster, or damaged, is an error.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "lode/io/height_formats.h"
#include "tests/io/height_files.h"
#include "tests/io/height_reading.h"
#include "tests/io/volume_test_files.h"
#include "tests/oracles/trials.h"

namespace lode::io {
namespace {

using test::RasterFile;
using test::write_raster;

class imported_raster : public test::HeightReading {};

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct ImportedKind {
  const char* name;
  const char* driver;
  GDALDataType type = GDT_Float32;
  double most_off = 0;       ///< Of heights.
  double most_moved = 1e-6;  ///< Of places, in degrees.
};

/// NITF has places in seconds, without decimals or with few.
constexpr double kSecond = 1.0 / 3600;

constexpr std::array kImportedKinds{ImportedKind{"a.ntf", "NITF", GDT_Int16, 0, kSecond},
                                    ImportedKind{"a.NITF", "NITF", GDT_Float32, 0, kSecond},
                                    ImportedKind{"a.gtx", "GTX"},
                                    ImportedKind{"a.rst", "RST"},
                                    ImportedKind{"a.map", "PCRaster"},
                                    ImportedKind{"a.gpkg", "GPKG", GDT_Int16},
                                    ImportedKind{"a.grb2", "GRIB", GDT_Float32, 1},
                                    ImportedKind{"a.ers", "ERS"},
                                    ImportedKind{"a.sigdem", "SIGDEM", GDT_Float64},
                                    ImportedKind{"a.mpr", "ILWIS", GDT_Int16}};

RasterFile half_degree(GDALDataType type) {
  RasterFile raster{.n_columns = 64, .n_rows = 48, .type = type};
  for (int i = 0; i < 64 * 48; ++i) raster.samples.push_back((i * 7919) % 4001 + 1);
  constexpr double kStep = 1.0 / 128;
  raster.geotransform = {8, kStep, 0, 47, 0, -kStep};
  raster.epsg = 4326;
  return raster;
}

TEST_F(imported_raster, has_the_heights_of_many_formats) {
  GDALAllRegister();
  for (const ImportedKind& kind : kImportedKinds) {
    SCOPED_TRACE(std::string(kind.name) + ", " + kind.driver);
    if (GDALGetDriverByName(kind.driver) == nullptr) continue;
    const std::string path = (*this)(kind.name);
    const RasterFile written = half_degree(kind.type);
    write_raster(path, written, kind.driver);
    EXPECT_TRUE(is_height_path(path));
    const HeightRaster raster = read(path);
    EXPECT_EQ(raster.format, kind.driver);
    ASSERT_EQ(raster.grid.n_columns, 64);
    ASSERT_EQ(raster.grid.n_rows, 48);
    EXPECT_EQ(raster.grid.n_missing(), 0U);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x)
        ASSERT_NEAR(raster.grid.height(x, y), written.samples[static_cast<std::size_t>(64 * y + x)],
                    kind.most_off);
    EXPECT_NEAR(raster.grid.world(0, 0)[0], 8 + 0.5 / 128, kind.most_moved);
    EXPECT_NEAR(raster.grid.world(0, 0)[1], 47 - 0.5 / 128, kind.most_moved);
    EXPECT_NEAR(raster.grid.world(63, 47)[0], 8 + 63.5 / 128, kind.most_moved);
  }
}

TEST_F(imported_raster, is_unpacked) {
  RasterFile written = half_degree(GDT_Float32);
  write_raster((*this)("a.asc"), written, "AAIGrid");
  write_raster((*this)("a.tif"), written);
  for (const char* name : {"a.asc", "a.tif"}) {
    const std::string packed = (*this)(std::string(name) + ".gz");
    std::ofstream(packed, std::ios::binary) << test::gzipped(content_of((*this)(name)));
    EXPECT_TRUE(is_height_path(packed));
    const HeightRaster raster = read(packed);
    EXPECT_EQ(raster.grid.n_columns, 64);
    expect_samples(raster.grid, written.samples);
  }
}

TEST_F(imported_raster, has_the_band_that_was_chosen_and_says_that_there_are_others) {
  RasterFile written = half_degree(GDT_Int16);
  written.n_bands = 2;
  const std::string path = (*this)("a.ers");
  write_raster(path, written, "ERS");
  EXPECT_EQ(read(path).grid.height(0, 0), written.samples[0]);
  EXPECT_EQ(read(path, {.band = 2}).grid.height(0, 0), written.samples[0] + 1000);
  EXPECT_NE(refusal(path, {.band = 3}).find("a band from 1 to 2, got 3"), std::string::npos);
  EXPECT_NE(refusal(path, {.variable = "z"}).find("netCDF"), std::string::npos);
}

TEST_F(imported_raster, is_an_error_of_what_is_none) {
  std::ofstream((*this)("text.ntf")) << "no raster";
  std::ofstream((*this)("empty.grb"));
  std::ofstream((*this)("no.asc.gz")) << "not packed";
  for (const char* name : {"text.ntf", "empty.grb", "no.asc.gz"}) {
    const std::string message = refusal((*this)(name));
    EXPECT_NE(message.find(name), std::string::npos) << message;
    if (std::string_view(name) != "empty.grb")
      EXPECT_NE(message.find("expected"), std::string::npos) << message;
  }
  EXPECT_NE(refusal((*this)("none.gpkg")).find("none.gpkg"), std::string::npos);
}

TEST_F(imported_raster, asks_no_network_for_what_it_names) {
  std::ofstream((*this)("ozi.map")) << "OziExplorer Map Data File Version 2.2\nx\n"
                                       "/vsicurl/http://127.0.0.1:9/x.tif\n";
  EXPECT_NE(refusal((*this)("ozi.map")).find("/vsi"), std::string::npos);
}

/// Whatever its drivers make of them, this process lives, and says which file it was.
TEST_F(imported_raster, does_no_harm_where_it_is_damaged) {
  GDALAllRegister();
  for (const ImportedKind& kind : kImportedKinds) {
    if (GDALGetDriverByName(kind.driver) == nullptr) continue;
    const std::string path = (*this)(kind.name);
    write_raster(path, half_degree(kind.type), kind.driver);
    const std::string whole = content_of(path);
    for (const std::size_t i :
         oracles::trials<std::vector<std::size_t>>({0, 1, 2, 3, 4, 5, 6, 7}, {2, 5})) {
      std::string damaged = whole;
      if (i < 4) damaged.resize(whole.size() * i / 4 + 1);
      for (std::size_t k = 0; i >= 4 && k < 20; ++k)
        damaged[(k * 7919 + i * 104729) % damaged.size()] = static_cast<char>(k * 37 + i);
      std::ofstream(path, std::ios::binary) << damaged;
      Progress progress;
      const auto raster = read_heights(path, {}, progress);
      if (!raster) EXPECT_NE(raster.error().message.find(kind.name), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace lode::io
