#include "lode/io/point_reader.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/io/point_files.h"
#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::LasFile;
using test::LasPoint;

/// A directory that is gone when the test is.
class point_reader : public testing::Test {
 protected:
  point_reader() {
    std::string name = testing::TempDir() + "/lode_points_XXXXXX";
    directory_ = mkdtemp(name.data());
  }
  ~point_reader() override { std::filesystem::remove_all(directory_); }

  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = (directory_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  static PointFile read(const std::string& path, const PointReadOptions& options = {}) {
    Progress progress;
    auto file = read_points(path, options, progress);
    if (!file) ADD_FAILURE() << file.error().message;
    return file ? std::move(file).value() : PointFile{};
  }
  static std::string refusal(const std::string& path, const PointReadOptions& options = {}) {
    Progress progress;
    const auto file = read_points(path, options, progress);
    EXPECT_FALSE(file) << path;
    if (file) return "";
    EXPECT_TRUE(file.error().message.starts_with(path)) << file.error().message;
    EXPECT_EQ(file.error().message.find('\n'), std::string::npos) << file.error().message;
    return file.error().message;
  }
  void expect_refusal(const std::string& name, const std::string& bytes,
                      const std::string& reason) const {
    const std::string message = refusal(write(name, bytes));
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }

  std::filesystem::path directory_;
};

const std::vector<LasPoint> kFour{{{100, 200, 300}, 2},
                                  {{-101, 250, 310}, 9, true},
                                  {{150, -260, 320}, 2, false, true},
                                  {{170, 280, -330}, 1}};

TEST_F(point_reader, takes_points_of_all_las_formats_and_versions) {
  for (std::uint8_t format = 0; format <= 10; ++format)
    for (const int minor : {0, 3, 4}) {
      SCOPED_TRACE(testing::Message() << "1." << minor << ", format " << int{format});
      const LasFile las{.minor = minor, .format = format, .points = kFour};
      const PointFile file = read(write("a.las", las.bytes()));
      ASSERT_EQ(file.points.size(), 3U);
      EXPECT_EQ(file.points[1], (Vec3d{{-101 * 0.01 + 500000, 250 * 0.01 + 4000000, 3.1}}));
      EXPECT_EQ(file.points[2][2], -330 * 0.01);
      EXPECT_EQ(file.lattice.step, 0.01);
      EXPECT_EQ(file.counts.n_in_file, 4U);
      EXPECT_EQ(file.counts.n_withheld, 1U);
      EXPECT_EQ(file.counts.n_synthetic, 1U);
      EXPECT_EQ(file.counts.of_class[2], 2U);
    }
}

TEST_F(point_reader, keeps_the_classes_that_are_asked_for) {
  const std::string path = write("a.las", LasFile{.points = kFour}.bytes());
  const PointFile file = read(path, {.classes = {2, 9}});
  EXPECT_EQ(file.points.size(), 2U);
  EXPECT_EQ(file.counts.n_other_class, 1U);
  EXPECT_EQ(file.counts.n_withheld, 1U);
  EXPECT_NE(refusal(path, {.classes = {7}}).find("3 are of other classes, 1 withheld"),
            std::string::npos);
  EXPECT_NE(refusal(write("a.xyz", "1 2 3\n"), {.classes = {2}}).find("no classes"),
            std::string::npos);
}

TEST_F(point_reader, finds_the_crs_in_wkt_and_geotiff_keys) {
  const std::string wkt = R"(LOCAL_CS["here",UNIT["metre",1]])";
  EXPECT_EQ(read(write("a.las", LasFile{.points = kFour, .wkt = wkt}.bytes())).crs, wkt);
  const LasFile extended{.minor = 4, .format = 6, .points = kFour, .extended_wkt = wkt};
  EXPECT_EQ(read(write("b.las", extended.bytes())).crs, wkt);
  const LasFile keys{.points = kFour,
                     .geo_keys = {1, 1, 0, 2, 3072, 0, 1, 32633, 4099, 0, 1, 9003}};
  const PointFile file = read(write("c.las", keys.bytes()));
  EXPECT_NE(file.crs.find("UTM zone 33N"), std::string::npos) << file.crs;
  EXPECT_EQ(file.vertical_unit, "us-ft");
  // GeoTIFF 1.0's number of NAVD88, which is that of its datum.
  const LasFile old{.points = kFour, .geo_keys = {1, 1, 0, 2, 3072, 0, 1, 26910, 4096, 0, 1, 5103}};
  EXPECT_NE(read(write("o.las", old.bytes())).crs.find("NAVD88"), std::string::npos);
  const LasFile own{.points = kFour, .geo_keys = {1, 1, 0, 1, 3072, 0, 1, 32767}};
  EXPECT_EQ(read(write("d.las", own.bytes())).crs_note, "its GeoTIFF keys have no EPSG code");
  const PointFile given = read(write("d.las", own.bytes()), {.crs = "EPSG:4326"});
  EXPECT_NE(given.crs.find("WGS 84"), std::string::npos);
  EXPECT_NE(refusal(write("d.las", own.bytes()), {.crs = "EPSG:none"}).find("EPSG:none"),
            std::string::npos);
}

TEST_F(point_reader, refuses_las_that_is_not_what_it_says) {
  const std::string good = LasFile{.points = kFour}.bytes();
  expect_refusal("a.las", good.substr(0, 100), "header of 227 bytes or more, got a file of 100");
  expect_refusal("a.las", "LASX" + good.substr(4), "'LASF' at offset 0");
  expect_refusal("a.las", good.substr(0, good.size() - 1), "expected 4 points of 20 bytes");
  const auto with = [&](std::size_t at, auto value) {
    std::string bytes = good;
    LasFile::put(bytes, at, value);
    return bytes;
  };
  expect_refusal("a.las", with(107, std::uint32_t{4000000000U}), "4000000000 points of 20 bytes");
  expect_refusal("a.las", with(107, std::uint32_t{0}), "the header says none");
  expect_refusal("a.las", with(25, std::uint8_t{5}), "expected LAS 1.0 to 1.4");
  expect_refusal("a.las", with(104, std::uint8_t{11}), "point format from 0 to 10 at offset 104");
  expect_refusal("a.laz", with(104, std::uint8_t{0x80}), "laszip -i IN.laz -o OUT.las");
  expect_refusal("a.las", with(105, std::uint16_t{19}), "records of 20 bytes or more");
  expect_refusal("a.las", with(105, std::uint16_t{0}), "records of 20 bytes or more");
  expect_refusal("a.las", with(96, std::uint32_t{100}), "got 227 and 100");
  expect_refusal("a.las", with(96, std::uint32_t{4000000000U}), "from offset 4000000000");
  expect_refusal("a.las", with(131, 0.0), "expected scales");
  expect_refusal("a.las", with(139, std::nan("")), "expected scales");
  expect_refusal("a.las", with(155, HUGE_VAL), "expected scales");
  expect_refusal("a.las", with(100, std::uint32_t{2}), "expected 2 records before the points");
  const std::string v14 = LasFile{.minor = 4, .points = kFour}.bytes();
  std::string many = v14;
  LasFile::put(many, 247, std::uint64_t{0} - 1);
  expect_refusal("a.las", many, "18446744073709551615 points");
  std::string extended = v14;
  LasFile::put(extended, 243, std::uint32_t{1});
  LasFile::put(extended, 235, std::uint64_t{1} << 60);
  expect_refusal("a.las", extended, "extended record at offset 1152921504606846976");
}

/// Whatever the bytes are it ends, with points or a sentence.
TEST_F(point_reader, survives_any_bytes) {
  const std::string las =
      LasFile{.minor = 4, .format = 6, .points = kFour, .wkt = "X[]", .geo_keys = {1, 1, 0, 1, 2}}
          .bytes();
  const std::string text = "x,y,z\n1,2,3\n4.5;6 7e1\n# no\n8 9 nan\n";
  std::mt19937 random(1);
  Progress progress;
  for (int i = 0; i < 3000; ++i)
    for (const auto& [name, good] : {std::pair{"a.las", las}, {"a.xyz", text}}) {
      std::string bytes = good.substr(0, 1 + random() % good.size());
      for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
      const auto read = read_points(write(name, bytes), {}, progress);
      if (read) EXPECT_LE(read->points.size(), bytes.size());
    }
}

TEST_F(point_reader, takes_text_with_all_separators_headings_and_comments) {
  const std::vector<Vec3d> expected{{{1.25, -2, 3}}, {{4e2, 5, 6.5}}};
  for (const char* text : {"1.25 -2 3\n4e2 5 6.5\n", "  1.25\t-2.0  3 7 8\r\n400;5 ; 6.50\r\n",
                           "# what it is\n\n1.25,-2,3\n400,5,6.5", "x y z\n1.25 -2 3\n4e2 5 6.5",
                           "\"depth\",name,\"Lat\",\"Lon\"\n3,a,-2,1.25\n6.5,,5,400\n",
                           "\xEF\xBB\xBFone,two,three\n1.25,-2,3\n400,5,6.5\n"}) {
    SCOPED_TRACE(text);
    EXPECT_EQ(read(write("a.xyz", text)).points, expected);
    EXPECT_EQ(read(write("a.csv.gz", test::gzipped(text))).points, expected);
    EXPECT_EQ(read(write("a.txt", text)).lattice.step, 0.01);
  }
}

TEST_F(point_reader, finds_the_columns_that_a_heading_names) {
  const std::vector<Vec3d> expected{{{20, 10, 5}}, {{21, 11, 6}}};
  for (const char* text :
       {"id;lon;lat;ele\n1;20;10;5\n2;21;11;6\n", "N,X,Y,Elev\n1,20,10,5\n2,21,11,6\n",
        "POINT_X,POINT_Y,GRID_CODE,\n20,10,5,\n21,11,6,a\n", "h n e\n5 10 20\n6 11 21\n",
        "x,lon,lat,alt\n1,20,10,5\n2,21,11,6\n",
        "id,\"Northing\",East,Altitude\n"
        "1,10,20,5\n2,11,21,6\n"}) {
    SCOPED_TRACE(text);
    EXPECT_EQ(read(write("a.csv", text)).points, expected);
  }
}

/// Else triangles would go round the world, and lengths be those of degrees.
TEST_F(point_reader, takes_longitudes_and_latitudes_for_those_of_wgs_84_and_says_so) {
  const std::string rows = "\n179,1,5\n-179,2,6\n";
  for (const char* names : {"lon,lat,z", "Longitude,Latitude,Elevation"}) {
    const PointFile file = read(write("a.csv", names + rows));
    EXPECT_NE(file.crs.find("WGS 84"), std::string::npos) << file.crs;
    ASSERT_EQ(file.vertical.notes.size(), 1U);
    EXPECT_NE(file.vertical.notes[0].find("--crs"), std::string::npos);
  }
  const PointFile stated = read(write("a.csv", "lon,lat,z" + rows), {.crs = "EPSG:4269"});
  EXPECT_NE(stated.crs.find("NAD83"), std::string::npos) << stated.crs;
  EXPECT_TRUE(stated.vertical.notes.empty());
  // Other names, and what is no latitude, are in a plane.
  EXPECT_EQ(read(write("a.csv", "x,y,z" + rows)).crs, "");
  const PointFile far = read(write("a.csv", "lon,lat,z\n5e5,4e6,1\n5e5,4.1e6,2\n"));
  EXPECT_EQ(far.crs, "");
  ASSERT_EQ(far.vertical.notes.size(), 1U);
  EXPECT_NE(far.vertical.notes[0].find("in a plane"), std::string::npos);
}

TEST_F(point_reader, refuses_headings_that_name_a_part_and_lists_the_names) {
  for (const char* names : {"id;lon;lat;dem", "lon;y;z", "x;z;lat", "a;b;c;d", "id;z;other"}) {
    const std::string message = refusal(write("a.csv", std::string(names) + "\n1;20;10;5\n"));
    for (const char* part : {names, "in line 1", "longitude", "northing", "grid_code"})
      EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
  }
}

TEST_F(point_reader, refuses_decimal_commas_and_lines_of_other_lengths) {
  for (const char* text : {"0,5 0,5 1\n10,5 0 2\n", "1.5,2.5,3\n0 10,5 3\n", "0,5;0,5;1\n",
                           "0,5\t1\t2\n", "1, 2, 0,5\n1, 2, 3\n", "1,2,3\n1,5, 2, 3\n"}) {
    const std::string path = write("a.csv", text);
    const std::string message = refusal(path);
    EXPECT_NE(message.find(" in line "), std::string::npos) << message;
    if (std::string_view(text) != "1, 2, 0,5\n1, 2, 3\n")
      EXPECT_NE(message.find("decimals need a point"), std::string::npos) << message;
  }
  expect_refusal("a.csv", "1,2,3,4\n\n1,2,3\n", "expected 4 columns, as before, in line 3, got 3");
  expect_refusal("a.csv", "x y z\n7 1 2 3\n", "expected 3 columns, as before, in line 2, got 4");
  // What is in quotes separates nothing.
  const PointFile named = read(write("a.csv", "name,x,y,z\n\"Foo, Bar\",1,2,3\n"));
  ASSERT_EQ(named.points.size(), 1U);
  EXPECT_EQ(named.points[0].v, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(read(write("a.csv", "1,2,3,\"a, b\"\n2,3,4,c\n")).points.size(), 2U);
  EXPECT_EQ(read(write("a.csv", "1,2,3,\n4, 5, 6\n7,8,9\n")).points.size(), 3U);
}

TEST_F(point_reader, takes_text_longer_than_its_buffers) {
  std::string text;
  for (int i = 0; i < 60000; ++i) text += fmt::format("{} {} {}\n", i, i % 7, 0.5 * i);
  for (const std::string& path : {write("a.xyz", text), write("a.xyz.gz", test::gzipped(text))}) {
    const PointFile file = read(path);
    ASSERT_EQ(file.points.size(), 60000U);
    for (int i = 0; i < 60000; ++i)
      ASSERT_EQ(file.points[static_cast<std::size_t>(i)],
                (Vec3d{{1.0 * i, 1.0 * (i % 7), 0.5 * i}}));
    EXPECT_EQ(file.lattice.step, 1);
  }
}

TEST_F(point_reader, counts_points_without_a_height) {
  const PointFile file =
      read(write("a.xyz", "0 0 1\n1 0 nan\n2 0 inf\n3 0 -9999\n4 0 2\n"), {.nodata = -9999.0});
  EXPECT_EQ(file.points.size(), 2U);
  EXPECT_EQ(file.counts.n_in_file, 5U);
  EXPECT_EQ(file.counts.n_missing, 3U);
  EXPECT_NE(refusal(write("a.xyz", "0 0 nan\n")).find("1 without a height"), std::string::npos);
}

TEST_F(point_reader, names_the_line_of_what_is_no_point) {
  for (const auto& [text, line] : {std::pair{"1 2 3\n1 2\n", 2},
                                   {"# a\n\n1 2 x\n", 3},
                                   {"x y z\n1 2 3\nnan 2 3\n", 3},
                                   {"1,,3\n", 1},
                                   {"1 inf 3\n", 1},
                                   {"a b c\nd e f\n", 2}}) {
    const std::string message = refusal(write("a.xyz", text));
    EXPECT_NE(message.find(fmt::format("in line {},", line)), std::string::npos) << message;
  }
  EXPECT_NE(refusal(write("a.xyz", "# nothing\n")).find("expected points, got none"),
            std::string::npos);
  EXPECT_NE(refusal(write("a.xyz", std::string(300000, 'a'))).find("65536 bytes in line 1"),
            std::string::npos);
  const std::string cut = test::gzipped("1 2 3\n4 5 6\n");
  EXPECT_FALSE(refusal(write("a.xyz.gz", cut.substr(0, cut.size() - 9))).empty());
  EXPECT_FALSE(refusal((directory_ / "none.xyz").string()).empty());
  EXPECT_FALSE(refusal(write("empty.xyz", "")).empty());
}

TEST_F(point_reader, knows_names_of_points_and_leaves_grids_of_plot3d_alone) {
  for (const char* name : {"a.las", "b.LAZ", "c.xyz", "d.XYZ.gz", "e.csv", "f.txt.gz"})
    EXPECT_TRUE(is_point_path(name)) << name;
  for (const char* name : {"a.tif", "a.gz", "a.xyzw", "las", "a.nrrd"})
    EXPECT_FALSE(is_point_path(name)) << name;
  const std::string grid = write("grid.xyz", "1");
  EXPECT_TRUE(is_point_path(grid));
  write("grid.q", "1");
  EXPECT_FALSE(is_point_path(grid));
  EXPECT_FALSE(is_point_path(write("binary.xyz", std::string("\x08\0\0\0\x02", 5))));
}

}  // namespace
}  // namespace lode::io
