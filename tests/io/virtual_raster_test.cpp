// VRT: rasters that are put together from files, as gdalbuildvrt makes them.

#include "lode/io/virtual_raster.h"

#include <fmt/format.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
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
  EXPECT_NE(refusal(build("hidden.vrt", paths, {"-hidenodata"})).find("are left out"),
            std::string::npos);
  // Parts whose missing samples would become heights.
  EXPECT_NE(refusal(build("copied.vrt", paths, {"-srcnodata", "None", "-vrtnodata", "None"}))
                .find("which would become heights"),
            std::string::npos);
  EXPECT_NE(refusal(build("other.vrt", paths, {"-srcnodata", "None", "-vrtnodata", "-5000"}))
                .find("which would become heights"),
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

TEST_F(virtual_raster, is_not_made_of_others) {
  const std::string vrt = build("all.vrt", tiles());
  const std::string two = build("two.vrt", {vrt});
  EXPECT_NE(refusal(two).find("expected parts that are no VRT themselves"), std::string::npos);
  // Whatever they are called, and whatever GDAL would take them for.
  std::string text = text_of(vrt);
  std::filesystem::remove((*this)("tile-2.tif"));
  std::ofstream((*this)("tile-2.tif")) << std::string(10, ' ') << text;
  EXPECT_NE(refusal(vrt).find("no VRT themselves"), std::string::npos) << refusal(vrt);
  std::ofstream((*this)("tile-2.tif")) << std::string(300, ' ') << text;
  EXPECT_NE(refusal(vrt).find("got VRT"), std::string::npos) << refusal(vrt);
  std::ofstream((*this)("tile-2.tif")) << "<GDAL_WMS><Service name=\"TMS\"/></GDAL_WMS>";
  EXPECT_NE(refusal(vrt).find("got WMS"), std::string::npos) << refusal(vrt);
}

TEST_F(virtual_raster, takes_names_from_where_the_file_is) {
  tiles();
  std::filesystem::create_directory((*this)("real"));
  std::filesystem::create_directory((*this)("links"));
  RasterFile real = part(0, 0, kTile, kTile);
  write_raster((*this)("real/t.tif"), real);
  std::ranges::fill(real.samples, 77);
  write_raster((*this)("links/t.tif"), real);
  build("real/m.vrt", {(*this)("real/t.tif")});
  std::filesystem::create_symlink((*this)("real/m.vrt"), (*this)("links/m.vrt"));
  for (const char* path : {"real/m.vrt", "links/m.vrt"})
    expect_samples(read((*this)(path)).grid, part(0, 0, kTile, kTile).samples);
}

TEST_F(virtual_raster, is_made_of_hgt_files) {
  GDALAllRegister();
  constexpr int kDegree = 1201;
  std::ofstream file((*this)("N46E010.hgt"), std::ios::binary);
  for (int i = 0; i < kDegree * kDegree; ++i) {
    const int height = i % 1000;
    file.put(static_cast<char>(height >> 8)).put(static_cast<char>(height & 255));
  }
  file.close();
  const HeightRaster raster = read(build("srtm.vrt", {(*this)("N46E010.hgt")}));
  ASSERT_EQ(raster.grid.n_columns, kDegree);
  EXPECT_EQ(raster.grid.height(7, 1), (kDegree + 7) % 1000);
  EXPECT_NEAR(raster.grid.world(0, 0)[0], 10, 1e-9);
  EXPECT_NEAR(raster.grid.world(0, 0)[1], 47, 1e-9);
}

TEST_F(virtual_raster, has_numbers_for_missing_samples_that_its_type_has) {
  std::vector<std::string> paths;
  GDALAllRegister();
  for (int i = 0; i < 2; ++i) {
    RasterFile raster = part(2 * i * kTile, 0, kTile, kTile);
    raster.type = GDT_UInt16;
    for (double& sample : raster.samples) sample += 200;
    paths.push_back((*this)(fmt::format("u{}.tif", i)));
    write_raster(paths.back(), raster);
  }
  EXPECT_EQ(read(build("good.vrt", paths, {"-vrtnodata", "65535"})).grid.n_missing(),
            static_cast<std::uint64_t>(kTile * kTile));
  for (const char* number : {"-9999", "70000", "0.5", "nan"})
    EXPECT_NE(refusal(build("odd.vrt", paths, {"-vrtnodata", number})).find("that the type has"),
              std::string::npos)
        << number;
  // Of one file, all samples of which are there.
  EXPECT_NE(refusal(build("odd.vrt", {paths[0]}, {"-vrtnodata", "-9999"})).find("UInt16 has not"),
            std::string::npos);
}

TEST_F(virtual_raster, is_covered_as_gdal_rounds) {
  const std::string vrt = build("all.vrt", tiles());
  const std::string near =
      changed(vrt, "<DstRect xOff=\"20\" yOff=\"0\"", "<DstRect xOff=\"20.0004\" yOff=\"0\"");
  EXPECT_EQ(read(near).grid.n_missing(), 0U);
  expect_samples(read(near).grid, part(0, 0, kSide, kSide).samples);
  // Coarser columns, of which the last is not all in a file.
  const std::string coarse =
      build("coarse.vrt", {(*this)("tile-0.tif")}, {"-tr", fmt::format("{}", 3.0 / kSide), "0.05"});
  EXPECT_EQ(read(coarse).grid.n_missing(), 0U);
  EXPECT_EQ(read(coarse).grid.n_columns, 7);
}

TEST_F(virtual_raster, may_have_gaps_in_bands_that_nobody_asks_for) {
  const std::vector<std::string> paths = tiles();
  write_raster((*this)("whole.tif"), part(0, 0, kSide, kSide));
  const std::string vrt = build("two.vrt", {(*this)("whole.tif"), paths[4]}, {"-separate"});
  expect_samples(read(vrt).grid, part(0, 0, kSide, kSide).samples);
  EXPECT_NE(refusal(vrt, {.band = 2}).find("in none of its 1 files"), std::string::npos);
  const std::string alpha = build("alpha.vrt", tiles({}, 4), {"-addalpha"});
  EXPECT_EQ(read(alpha).grid.n_missing(), 400U);
  // Of three bands GDAL takes none for the opacity of the others.
  const std::string three =
      changed(build("three.vrt", {paths[0], paths[1], paths[0]}, {"-separate"}),
              "<VRTRasterBand dataType=\"Int16\" band=\"3\">",
              "<VRTRasterBand dataType=\"Int16\" band=\"3\"><ColorInterp>Alpha</ColorInterp>");
  EXPECT_NE(refusal(three).find("are in none"), std::string::npos) << refusal(three);
}

TEST_F(virtual_raster, says_of_numbers_what_its_files_do) {
  std::vector<std::string> paths = tiles();
  RasterFile scaled = part(0, 0, kTile, kTile);
  scaled.scale = 0.1;
  scaled.unit = "ft";
  write_raster(paths[0], scaled);
  const std::string vrt = build("scaled.vrt", {paths[0]});
  EXPECT_NE(refusal(changed(vrt, "<Scale>0.1</Scale>", "")).find("expected the Scale 0.1"),
            std::string::npos);
  const HeightRaster raster = read(vrt);
  EXPECT_EQ(raster.grid.vertical_unit, "ft");
  EXPECT_NEAR(raster.grid.height(3, 2), 0.1 * height_of(3, 2), 1e-6);
  scaled.scale = 1;
  write_raster(paths[0], scaled);
  EXPECT_NE(refusal(build("mixed.vrt", paths)).find("of one unit"), std::string::npos);
  RasterFile bytes = part(0, 0, kTile, kTile);
  for (double& sample : bytes.samples) sample = std::fmod(sample, 100);
  bytes.type = GDT_Byte;
  bytes.is_signed_byte = true;
  write_raster((*this)("signed.tif"), bytes);
  EXPECT_NE(refusal(build("signed.vrt", {(*this)("signed.tif")})).find("signed bytes"),
            std::string::npos);
  // A number in fewer digits than the file's float has.
  RasterFile floats = part(0, 0, kTile, kTile);
  floats.type = GDT_Float32;
  floats.samples[5] = floats.nodata.emplace(-3.4028234663852886e+38);
  write_raster((*this)("f.tif"), floats);
  const std::string old = changed(build("f.vrt", {(*this)("f.tif")}), "<NoDataValue>",
                                  "<NoDataValue>-3.40282346638529E+38</NoDataValue><Was>");
  std::string fixed = text_of(old);
  fixed.replace(fixed.rfind("</NoDataValue>"), 14, "</Was>");
  std::ofstream((*this)("old.vrt")) << fixed;
  EXPECT_EQ(read((*this)("old.vrt")).grid.n_missing(), 1U);
}

TEST_F(virtual_raster, of_colours_wants_an_encoding) {
  GDALAllRegister();
  RasterFile picture = part(0, 0, kTile, kTile);
  for (double& sample : picture.samples) sample = std::fmod(std::abs(sample), 200);
  picture.type = GDT_Byte;
  picture.n_bands = 3;
  write_raster((*this)("rgb.tif"), picture);
  const std::string vrt = build("rgb.vrt", {(*this)("rgb.tif")});
  EXPECT_NE(refusal(vrt).find("--encoding"), std::string::npos) << refusal(vrt);
  EXPECT_EQ(read(vrt, {.encoding = HeightEncoding::terrarium}).grid.n_missing(), 0U);
}

TEST_F(virtual_raster, is_refused_where_it_is_more_than_parts_of_files) {
  const std::string vrt = build("all.vrt", tiles());
  const std::string band = "<VRTRasterBand dataType=\"Int16\" band=\"1\"";
  for (const char* kind : {"VRTDerivedRasterBand", "VRTRawRasterBand", "VRTWarpedRasterBand"})
    for (const char* name : {"subClass", "subclass", "SUBCLASS"})
      EXPECT_NE(
          refusal(changed(vrt, band, fmt::format("{} {}=\"{}\"", band, name, kind))).find(kind),
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
  EXPECT_NE(refusal(changed(vrt, "<SourceBand>1<", "<LUT>0:0,1:2</LUT><SourceBand>1<")).find("LUT"),
            std::string::npos);
  EXPECT_NE(refusal(changed(vrt, "<SimpleSource>",
                            "<subClass>VRTRawRasterBand</subClass>"
                            "<SimpleSource>"))
                .find("VRTRawRasterBand"),
            std::string::npos);
  // What is not known here does not reach GDAL.
  EXPECT_EQ(read(changed(vrt, "<SimpleSource>",
                         "<Overview><SourceFilename>/vsicurl/http://localhost/</SourceFilename>"
                         "<SourceBand>1</SourceBand></Overview><SimpleSource>"))
                .grid.n_missing(),
            0U);
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
