#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::bytes_of;
using test::expect_failure;
using test::info_of;
using test::ramp;
using test::samples_of;
using test::TempDir;

const std::string kNrrdStart = "NRRD0004\n# a comment\ntype: short\ndimension: 3\nsizes: 4 3 2\n";

TEST(nrrd_reader, reads_every_encoding) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  const std::string raw = bytes_of(samples);
  std::string text;
  std::string hex;
  for (const std::int16_t s : samples) text += fmt::format("{} ", s);
  for (const char c : raw) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
  const std::string start = kNrrdStart + "endian: little\nencoding: ";
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.nrrd", start + "raw\n\n" + raw)), samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("b.nrrd", start + "gzip\n\n" + test::gzipped(raw))),
            samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("c.nrrd", start + "ascii\n\n" + text)), samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("d.nrrd", start + "hex\n\n" + hex)), samples);
}

TEST(nrrd_reader, reads_detached_headers_with_skips_in_either_byte_order) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  const std::string raw = bytes_of(samples, ByteOrder::big);
  const std::string start = kNrrdStart + "endian: big\n";
  dir.write("a.raw", "line one\nline two\nxyz" + raw);
  dir.write("a.raw.gz", test::gzipped("xyz" + raw));
  const auto plain =
      dir.write("a.nhdr", start + "encoding: raw\ndata file: a.raw\nline skip: 2\nbyte skip: 3\n");
  const auto from_end =
      dir.write("b.nhdr", start + "encoding: raw\ndatafile: a.raw\nbyte skip: -1\n\n");
  const auto zipped =
      dir.write("c.nhdr", start + "encoding: gz\ndata file: a.raw.gz\nbyte skip: 3\n");
  EXPECT_EQ(samples_of<std::int16_t>(plain), samples);
  EXPECT_EQ(samples_of<std::int16_t>(from_end), samples);
  EXPECT_EQ(samples_of<std::int16_t>(zipped), samples);
}

TEST(nrrd_reader, keeps_space_directions_origin_and_frame) {
  const TempDir dir;
  const std::string raw(48, 'x');
  const auto path =
      dir.write("a.nrrd", kNrrdStart +
                              "endian: little\nencoding: raw\nspace: left-posterior-superior\n"
                              "space directions: (0,2,0) (-0.5, 0, 0) (0,0,3)\n"
                              "space origin: (10,-20,30.5)\nkinds: domain domain domain\n\n" +
                              raw);
  const RegularGrid grid = info_of(path).grid;
  EXPECT_EQ(grid.frame, Frame::lps);
  EXPECT_EQ(grid.spacing, (Vec3d{{2, 0.5, 3}}));
  EXPECT_EQ(grid.origin, (Vec3d{{10, -20, 30.5}}));
  EXPECT_EQ(grid.to_world({{1, 2, 1}}), (Vec3d{{9, -18, 33.5}}));
}

TEST(nrrd_reader, reads_spacings_axis_mins_and_missing_axes) {
  const TempDir dir;
  const auto path = dir.write("a.nrrd",
                              "NRRD0001\ntype: uchar\ndimension: 2\nsizes: 3 2\nspacings: 0.5 nan\n"
                              "axis mins: 10 20\naxis maxs: 11.5 22\ncenters: node node\n"
                              "encoding: raw\n\nabcdef");
  const RegularGrid grid = info_of(path).grid;
  EXPECT_EQ(grid.dims, (Index3{{3, 2, 1}}));
  EXPECT_EQ(grid.spacing, (Vec3d{{0.5, 2, 1}}));
  EXPECT_EQ(grid.origin, (Vec3d{{10, 20, 0}}));
}

TEST(nrrd_reader, finds_components_first_or_last_by_kind_or_direction) {
  const TempDir dir;
  const std::string raw = bytes_of(ramp<std::int16_t>(48));
  const std::string start = "NRRD0005\ntype: int16\ndimension: 4\nendian: little\nencoding: raw\n";
  const auto first = dir.write("a.nrrd", start +
                                             "sizes: 2 4 3 2\nkinds: vector domain domain "
                                             "domain\n\n" +
                                             raw);
  const auto last = dir.write("b.nrrd", start +
                                            "sizes: 4 3 2 2\nspace: RAS\nspace directions: "
                                            "(1,0,0) (0,1,0) (0,0,1) none\n\n" +
                                            raw);
  const auto all = ramp<std::int16_t>(48);
  ReadOptions options;
  options.component = 1;
  const auto from_first = samples_of<std::int16_t>(first, options);
  const auto from_last = samples_of<std::int16_t>(last, options);
  ASSERT_EQ(from_first.size(), 24U);
  ASSERT_EQ(from_last.size(), 24U);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_EQ(from_first[i], all[2 * i + 1]);
    EXPECT_EQ(from_last[i], all[24 + i]);
  }
  expect_failure(first, {"2 components", "--component N", "--component magnitude"});
}

TEST(nrrd_reader, takes_a_fourth_axis_as_time) {
  const TempDir dir;
  const auto all = ramp<std::int16_t>(48);
  const auto path = dir.write("a.nrrd",
                              "NRRD0005\ntype: int16\ndimension: 4\nendian: little\nencoding: raw\n"
                              "sizes: 4 3 2 2\n\n" +
                                  bytes_of(all));
  expect_failure(path, {"2 times", "--time N"});
  ReadOptions options;
  options.time = 1;
  EXPECT_EQ(samples_of<std::int16_t>(path, options),
            std::vector<std::int16_t>(all.begin() + 24, all.end()));
  options.time = 2;
  expect_failure(path, {"--time between 0 and 1, got 2"}, options);
}

TEST(nrrd_reader, refuses_truncated_and_overlong_data) {
  const TempDir dir;
  const std::string raw = bytes_of(ramp<std::int16_t>(24));
  const std::string start = kNrrdStart + "endian: little\nencoding: ";
  expect_failure(dir.write("a.nrrd", start + "raw\n\n" + raw.substr(1)), {"48 bytes", "47"});
  expect_failure(dir.write("b.nrrd", start + "gzip\n\n" + test::gzipped(raw.substr(2))),
                 {"expected 48 bytes", "hold 46"});
  expect_failure(dir.write("c.nrrd", start + "gzip\n\n" + test::gzipped(raw + "x")), {"more"});
  expect_failure(dir.write("d.nrrd", start + "ascii\n\n1 2 3"), {"24 numbers"});
  expect_failure(dir.write("e.nrrd", start + "hex\n\n" + std::string(95, 'a')), {"48 bytes"});
  expect_failure(
      dir.write("f.nrrd", start + "ascii\n\n" + std::string(24, '1') + std::string(60, ' ')),
      {"expected a number of type int16"});
}

TEST(nrrd_reader, refuses_sizes_that_overflow_or_exceed_the_file) {
  const TempDir dir;
  const std::string end = "endian: little\nencoding: raw\n\nxxxx";
  const std::string start = "NRRD0004\ntype: short\ndimension: 3\nsizes: ";
  expect_failure(dir.write("a.nrrd", start + "4294967296 4294967296 4294967296\n" + end), {"2^63"});
  expect_failure(dir.write("b.nrrd", start + "2000000000 2000000000 1\n" + end), {"promises"});
  expect_failure(dir.write("c.nrrd", start + "4294967296 1 1\n" + end), {"axis x"});
  expect_failure(dir.write("d.nrrd", start + "2 0 1\n" + end), {"at least 1, got 0"});
  expect_failure(dir.write("e.nrrd", start + "2 -2 -1\n" + end), {"at least 1, got -2"});
  expect_failure(dir.write("f.nrrd", start + "2 1\n" + end), {"expected 3 sizes", "'2 1'"});
}

TEST(nrrd_reader, refuses_what_it_cannot_know) {
  const TempDir dir;
  const std::string raw(48, 'x');
  expect_failure(dir.write("a.nrrd", kNrrdStart + "encoding: raw\n\n" + raw), {"endian", "int16"});
  expect_failure(dir.write("b.nrrd", kNrrdStart + "endian: little\n\n" + raw), {"'encoding'"});
  expect_failure(dir.write("c.nrrd", kNrrdStart + "endian: little\nencoding: bzip2\n\n" + raw),
                 {"'bzip2'"});
  expect_failure(dir.write("d.nrrd", "NRRD0004\ntype: block\ndimension: 1\nsizes: 1\n\n"),
                 {"'block'"});
  expect_failure(dir.write("f.nrrd", kNrrdStart +
                                         "endian: little\nencoding: raw\nspace directions: "
                                         "(1,0,0) (0,1,0) (1,1,0)\n\n" +
                                         raw),
                 {"independent"});
}

/// Writes the samples into files of equal size, called by name(i).
template <typename Name>
void write_pieces(const TempDir& dir, const std::string& bytes, std::size_t n, const Name& name) {
  const std::size_t size = bytes.size() / n;
  for (std::size_t i = 0; i < n; ++i) dir.write(name(i), bytes.substr(i * size, size));
}

TEST(nrrd_reader, joins_listed_data_files_along_the_slowest_axis) {
  const TempDir dir;
  std::filesystem::create_directory(dir.path("slices"));
  const auto samples = ramp<std::int16_t>(24);
  const std::string raw = bytes_of(samples, ByteOrder::big);
  const std::string start = kNrrdStart + "endian: big\nencoding: ";
  dir.write("slices/one.raw", raw.substr(0, 24));
  dir.write("two.raw", raw.substr(24));
  dir.write("one.gz", test::gzipped("xyz" + raw.substr(0, 24)));
  dir.write("two.gz", test::gzipped("xyz" + raw.substr(24)));
  dir.write("one.hex", "a line\n" + std::string(48, '0'));
  dir.write("two.hex", "a line\n" + std::string(48, 'f'));
  const std::string list = "data file: LIST\nslices/one.raw\r\n" + dir.path("two.raw");
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.nhdr", start + "raw\n" + list)), samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("b.nhdr", start + "raw\n" + list + "\n\nignored\n")),
            samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write(
                "c.nhdr", start + "gzip\nbyte skip: 3\ndata file: LIST 2\none.gz\ntwo.gz\n")),
            samples);
  std::vector<std::int16_t> halves(24, 0);
  std::fill(halves.begin() + 12, halves.end(), std::int16_t{-1});
  EXPECT_EQ(samples_of<std::int16_t>(dir.write(
                "d.nhdr", start + "hex\nline skip: 1\ndatafile: LIST\none.hex\ntwo.hex\n")),
            halves);
}

TEST(nrrd_reader, joins_numbered_data_files_of_any_number_of_axes) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  const std::string raw = bytes_of(samples);
  const std::string start = kNrrdStart + "endian: little\nencoding: raw\ndata file: ";
  write_pieces(dir, raw, 2, [](std::size_t i) { return fmt::format("slice{:03}.raw", 9 + i); });
  write_pieces(dir, raw, 2, [](std::size_t i) { return fmt::format("back{}.raw", 2 - 2 * i); });
  write_pieces(dir, raw, 6, [](std::size_t i) { return fmt::format("row{:2}", 5 * i); });
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.nhdr", start + "slice%03d.raw 9 10 1\n")),
            samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("b.nhdr", start + "./back%d.raw 2 0 -2\n")),
            samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("c.nhdr", start + "row%2d 0 29 5 1\n")), samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("d.nhdr", start + "slice%03d.raw 9 10 1 3\n")),
            samples);
}

TEST(nrrd_reader, refuses_data_files_that_do_not_fit) {
  const TempDir dir;
  const std::string start = kNrrdStart + "endian: little\nencoding: raw\ndata file: ";
  dir.write("1", std::string(24, 'x'));
  dir.write("2", std::string(23, 'x'));
  expect_failure(dir.write("a.nhdr", start + "LIST\n1\n"), {"2 data files", "got 1"});
  expect_failure(dir.write("b.nhdr", start + "LIST\n"), {"2 data files", "got 0"});
  expect_failure(dir.write("c.nhdr", start + "LIST 3\n1\n1\n1\n"), {"2 slices", "3 files"});
  expect_failure(dir.write("d.nhdr", start + "LIST 4\n1\n2\n"), {"1 to 3 axes, got 4"});
  expect_failure(dir.write("e.nhdr", start + "LIST x\n1\n2\n"), {"LIST subdim", "'LIST x'"});
  for (const char* pattern : {"%d 1 2", "%d 1 2 0", "%d 2 1 1", "%d 1 2 -5", "%d 1 2 1 1 1",
                              "%s 1 2 1", "%d%d 1 2 1", "%9999d 1 2 1", "% 1 2 1", "%d 1 1e99 1"})
    expect_failure(dir.write("f.nhdr", start + pattern + "\n"), {"slice%03d.raw 1 9 1", pattern});
  expect_failure(dir.write("g.nhdr", start + "%d 1 4000000000 1\n"), {"at most 65536 data files"});
  const auto complaint = [](const std::string& path) {
    const auto source = open_volume(path, {});
    return source ? "" : source.error().message;
  };
  EXPECT_NE(complaint(dir.write("h.nhdr", start + "%d 1 2 1\n")).find(dir.path("2") + ": "),
            std::string::npos);
  EXPECT_NE(complaint(dir.write("i.nhdr", start + "%d 0 1 1\n")).find(dir.path("0") + ": "),
            std::string::npos);
}

TEST(nrrd_reader, names_a_missing_data_file) {
  const TempDir dir;
  const auto path =
      dir.write("a.nhdr", kNrrdStart + "endian: little\nencoding: raw\ndata file: gone.raw\n");
  const auto source = open_volume(path, {});
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().message.find(dir.path("gone.raw")), std::string::npos);
}

TEST(nrrd_reader, gives_up_early_on_garbage_and_endless_headers) {
  const TempDir dir;
  expect_failure(dir.write("a.nrrd", std::string(5000, '\x01')), {"NRRD000"});
  expect_failure(dir.write("b.nrrd", "NRRD0004\n" + std::string(100000, 'x')), {"longer than"});
  std::string endless = "NRRD0004\n";
  for (int i = 0; i < 40000; ++i) endless += "# comment number something or other\n";
  expect_failure(dir.write("c.nrrd", endless), {"header of at most"});
  expect_failure(dir.write("d.nrrd", "NRRD0004\nnonsense\n\n"), {"'nonsense'"});
}

}  // namespace
}  // namespace lode::io
