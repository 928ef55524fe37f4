// VRT: rasters that are put together from files, as gdalbuildvrt makes them.

#include "lode/io/virtual_raster.h"

#include <fmt/format.h>
#include <gdal_utils.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "tests/io/height_files.h"
#include "tests/io/height_reading.h"
#include "tests/oracles/random.h"

namespace lode::io {
namespace {

using test::RasterFile;
using test::write_raster;

constexpr int kSide = 60;
constexpr int kTile = 20;  ///< Nine of them.

double height_of(int x, int y) { return (x * 7919 + y * 104729) % 4001 - 100; }

/// Columns and rows from here on of what is at 10 to 11 degrees east and 46 to 47 north.
RasterFile part(int left, int top, int n_columns, int n_rows) {
  RasterFile raster{.n_columns = n_columns, .n_rows = n_rows};
  for (int y = 0; y < n_rows; ++y)
    for (int x = 0; x < n_columns; ++x) raster.samples.push_back(height_of(left + x, top + y));
  constexpr double kStep = 1.0 / kSide;
  raster.geotransform = {10 + left * kStep, kStep, 0, 47 - top * kStep, 0, -kStep};
  raster.epsg = 4326;
  return raster;
}

class virtual_raster : public test::HeightReading {
 protected:
  /// What gdalbuildvrt makes of these.
  std::string build(const std::string& name, const std::vector<std::string>& parts,
                    const std::vector<std::string>& options = {}) {
    std::vector<std::string> words = options;
    std::vector<char*> list;
    for (std::string& word : words) list.push_back(word.data());
    list.push_back(nullptr);
    std::vector<const char*> names;
    for (const std::string& each : parts) names.push_back(each.c_str());
    GDALBuildVRTOptions* made = GDALBuildVRTOptionsNew(list.data(), nullptr);
    GDALDatasetH vrt = GDALBuildVRT((*this)(name).c_str(), static_cast<int>(names.size()), nullptr,
                                    names.data(), made, nullptr);
    GDALBuildVRTOptionsFree(made);
    EXPECT_NE(vrt, nullptr);
    if (vrt != nullptr) GDALClose(vrt);
    return (*this)(name);
  }
  /// All nine, or but one.
  std::vector<std::string> tiles(std::optional<double> nodata = {}, int but = -1) {
    GDALAllRegister();
    std::vector<std::string> paths;
    for (int i = 0; i < 9; ++i) {
      if (i == but) continue;
      RasterFile raster = part(i % 3 * kTile, i / 3 * kTile, kTile, kTile);
      raster.nodata = nodata;
      paths.push_back((*this)(fmt::format("tile-{}.tif", i)));
      write_raster(paths.back(), raster);
    }
    return paths;
  }
  std::string text_of(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  /// A mosaic with this in place of that.
  std::string changed(const std::string& vrt, const std::string& from, const std::string& to) {
    std::string text = text_of(vrt);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from << " in " << text;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    std::ofstream((*this)("changed.vrt")) << text;
    return (*this)("changed.vrt");
  }
};

TEST_F(virtual_raster, is_read_as_what_it_was_cut_from) {
  const std::string vrt = build("all.vrt", tiles());
  EXPECT_NE(text_of(vrt).find("relativeToVRT=\"1\""), std::string::npos);
  write_raster((*this)("whole.tif"), part(0, 0, kSide, kSide));
  const HeightRaster whole = read((*this)("whole.tif"));
  std::filesystem::rename(vrt, (*this)("named.otherwise"));
  for (const std::string& path : {(*this)("named.otherwise"), build("again.vrt", tiles())}) {
    const HeightRaster raster = read(path);
    EXPECT_EQ(raster.format, "VRT");
    ASSERT_EQ(raster.grid.n_columns, kSide);
    ASSERT_EQ(raster.grid.n_rows, kSide);
    EXPECT_EQ(raster.grid.heights.index(), whole.grid.heights.index());
    EXPECT_EQ(raster.grid.n_missing(), 0U);
    expect_samples(raster.grid, part(0, 0, kSide, kSide).samples);
    EXPECT_EQ(raster.grid.crs, whole.grid.crs);
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(raster.grid.to_world[i], whole.grid.to_world[i], 1e-9);
  }
}

TEST_F(virtual_raster, has_holes_where_no_file_is_and_says_so) {
  const std::string bare = build("gap.vrt", tiles({}, 4));
  EXPECT_NE(refusal(bare).find("400 of 60 x 60 samples are in none of its 8 files"),
            std::string::npos)
      << refusal(bare);
  const HeightRaster raster = read(build("gap.vrt", tiles({}, 4), {"-vrtnodata", "-999"}));
  EXPECT_EQ(raster.grid.n_missing(), 400U);
  EXPECT_FALSE(raster.grid.has_height(30, 30));
  EXPECT_TRUE(raster.grid.has_height(19, 30));
  expect_samples(raster.grid, part(0, 0, kSide, kSide).samples);
}

TEST_F(virtual_raster, has_holes_where_its_files_have) {
  const std::vector<std::string> paths = tiles(height_of(30, 30));
  const std::string vrt = build("holes.vrt", paths);
  std::uint64_t n = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) n += height_of(x, y) == height_of(30, 30) ? 1 : 0;
  EXPECT_EQ(read(vrt).grid.n_missing(), n);
  EXPECT_FALSE(read(vrt).grid.has_height(30, 30));
  EXPECT_NE(refusal(build("hidden.vrt", paths, {"-hidenodata"})).find("some are left out"),
            std::string::npos);
  // Parts whose missing samples would become heights.
  EXPECT_NE(refusal(build("copied.vrt", paths, {"-srcnodata", "None", "-vrtnodata", "None"}))
                .find("which would become a height, got none"),
            std::string::npos);
  EXPECT_NE(refusal(build("other.vrt", paths, {"-srcnodata", "None", "-vrtnodata", "-5000"}))
                .find("which would become a height, got -5000"),
            std::string::npos);
}

TEST_F(virtual_raster, is_refused_where_parts_are_not_there) {
  const std::string vrt = build("all.vrt", tiles());
  std::filesystem::rename((*this)("tile-7.tif"), (*this)("tile-x.tif"));
  EXPECT_NE(refusal(vrt).find("tile-7.tif'"), std::string::npos) << refusal(vrt);
  std::ofstream((*this)("tile-7.tif")) << "no raster";
  EXPECT_NE(refusal(vrt).find("to be a GeoTIFF"), std::string::npos) << refusal(vrt);
  std::ofstream((*this)("tile-7.tif")) << "CDF\1 and more";
  EXPECT_NE(refusal(vrt).find("got netCDF"), std::string::npos) << refusal(vrt);
  std::filesystem::remove((*this)("tile-7.tif"));
  std::filesystem::create_directory((*this)("tile-7.tif"));
  EXPECT_NE(refusal(vrt).find("no such file"), std::string::npos) << refusal(vrt);
}

TEST_F(virtual_raster, may_be_of_others_but_not_of_itself) {
  const std::vector<std::string> paths = tiles();
  std::vector<std::string> rows;
  for (std::size_t i = 0; i < 3; ++i)
    rows.push_back(
        build(fmt::format("row-{}.vrt", i), {paths[3 * i], paths[3 * i + 1], paths[3 * i + 2]}));
  const std::string vrt = build("rows.vrt", rows);
  expect_samples(read(vrt).grid, part(0, 0, kSide, kSide).samples);
  const std::string own = changed(vrt, "row-1.vrt", "changed.vrt");
  EXPECT_NE(refusal(own).find("no part of itself"), std::string::npos) << refusal(own);
  std::filesystem::copy_file(own, rows[0], std::filesystem::copy_options::overwrite_existing);
  EXPECT_NE(refusal(vrt).find("row-0.vrt: "), std::string::npos) << refusal(vrt);
}

TEST_F(virtual_raster, is_refused_where_it_is_more_than_parts_of_files) {
  const std::string vrt = build("all.vrt", tiles());
  const std::string band = "<VRTRasterBand dataType=\"Int16\" band=\"1\"";
  for (const char* kind : {"VRTDerivedRasterBand", "VRTRawRasterBand", "VRTWarpedRasterBand"})
    EXPECT_NE(refusal(changed(vrt, band, fmt::format("{} subClass=\"{}\"", band, kind))).find(kind),
              std::string::npos);
  for (const char* kind : {"VRTWarpedDataset", "VRTPansharpenedDataset"})
    EXPECT_NE(refusal(changed(vrt, "<VRTDataset", fmt::format("<VRTDataset subClass=\"{}\"", kind)))
                  .find(kind),
              std::string::npos);
  for (const char* name : {"/vsicurl/http://localhost/a.tif", "&lt;VRTDataset/&gt;", ""})
    EXPECT_NE(refusal(changed(vrt, ">tile-3.tif<", fmt::format(">{}<", name)))
                  .find("expected parts of files"),
              std::string::npos);
  EXPECT_NE(refusal(changed(vrt, "<SourceBand>1<", "<SourceBand>2<")).find("to have a band 2"),
            std::string::npos);
  EXPECT_NE(refusal(changed(vrt, "<DstRect xOff=\"0\"", "<DstRect xOff=\"inf\"")).find("DstRect"),
            std::string::npos);
  EXPECT_NE(
      refusal(changed(vrt, "<SrcRect xOff=\"0\"", "<SrcRect xOff=\"5\"")).find("SrcRect inside"),
      std::string::npos);
  EXPECT_NE(refusal(changed(vrt, "rasterXSize=\"60\"", "rasterXSize=\"-1\"")).find("rasterXSize"),
            std::string::npos);
  // More samples than these files can have, of which most are in none.
  EXPECT_NE(refusal(changed(vrt, "rasterXSize=\"60\"", "rasterXSize=\"2147483647\"")), "");
  std::string text = text_of(vrt);
  text.insert(text.find("<SimpleSource>"), "<KernelFilteredSource/>");
  std::ofstream((*this)("kernel.vrt")) << text;
  EXPECT_NE(refusal((*this)("kernel.vrt")).find("KernelFilteredSource"), std::string::npos);
}

TEST_F(virtual_raster, is_refused_or_read_whatever_is_cut_or_changed) {
  const std::string text = text_of(build("all.vrt", tiles()));
  oracles::Random random(5);
  Progress progress;
  for (int i = 0; i < 400; ++i) {
    std::string broken = text;
    if (i % 2 == 0)
      broken.resize(random.below(broken.size()));
    else
      for (int k = 0; k < 3; ++k)
        broken[random.below(broken.size())] = static_cast<char>(32 + random.below(95));
    std::ofstream((*this)("broken.vrt")) << broken;
    const auto raster = read_heights((*this)("broken.vrt"), {}, progress);
    if (!raster) {
      EXPECT_NE(raster.error().message, "");
    }
  }
  for (const char* empty :
       {"", "<VRTDataset/>", "<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"/>",
        "<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"><MaskBand/>"
        "</VRTDataset>"}) {
    std::ofstream((*this)("broken.vrt")) << empty;
    EXPECT_NE(refusal((*this)("broken.vrt")), "") << empty;
  }
}

/// Of whole numbers, counted one by one.
TEST(uncovered_samples, are_those_in_no_part) {
  oracles::Random random(11);
  for (int round = 0; round < 200; ++round) {
    VirtualRaster raster{.n_columns = 1 + static_cast<int>(random.below(12)),
                         .n_rows = 1 + static_cast<int>(random.below(12))};
    VirtualBand band;
    for (std::size_t n = random.below(6); n > 0; --n) {
      VirtualSource source;
      const double left = static_cast<double>(random.below(16)) - 2;
      const double top = static_cast<double>(random.below(16)) - 2;
      source.part = {left, top, left + static_cast<double>(random.below(8)),
                     top + static_cast<double>(random.below(8))};
      band.sources.push_back(source);
    }
    int expected = 0;
    for (int y = 0; y < raster.n_rows; ++y)
      for (int x = 0; x < raster.n_columns; ++x)
        expected += std::ranges::none_of(band.sources, [&](const VirtualSource& source) {
          return source.part->left <= x && x < source.part->right && source.part->top <= y &&
                 y < source.part->bottom;
        });
    EXPECT_EQ(uncovered_samples(raster, band), expected);
  }
}

}  // namespace
}  // namespace lode::io
