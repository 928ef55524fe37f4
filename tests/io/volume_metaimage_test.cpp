#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::bytes_of;
using test::expect_failure;
using test::info_of;
using test::ramp;
using test::samples_of;
using test::TempDir;

const std::string kMetaStart = "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\n";
const std::string kShort = kMetaStart + "ElementType = MET_SHORT\n";

TEST(metaimage_reader, reads_plain_compressed_and_text_data) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  const std::string raw = bytes_of(samples);
  std::string text;
  for (const std::int16_t s : samples) text += fmt::format("{}\n", s);
  const std::string local = "ElementDataFile = LOCAL\n";
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.mha", kShort + local + raw)), samples);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write(
                "b.mha", kShort + "CompressedData = True\n" + local + test::zlibbed(raw))),
            samples);
  EXPECT_EQ(
      samples_of<std::int16_t>(dir.write("c.mha", kShort + "BinaryData = False\n" + local + text)),
      samples);
}

TEST(metaimage_reader, reads_data_files_in_either_byte_order_with_skips) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  dir.write("a.raw", "12345" + bytes_of(samples, ByteOrder::big));
  const std::string start = kShort + "BinaryDataByteOrderMSB = True\n";
  const auto counted = dir.write("a.mhd", start + "HeaderSize = 5\nElementDataFile = a.raw\n");
  const auto from_end = dir.write("b.mhd", start + "HeaderSize = -1\nElementDataFile = a.raw");
  EXPECT_EQ(samples_of<std::int16_t>(counted), samples);
  EXPECT_EQ(samples_of<std::int16_t>(from_end), samples);
}

TEST(metaimage_reader, knows_every_element_type) {
  const TempDir dir;
  const std::pair<const char*, ScalarType> types[] = {
      {"MET_UCHAR", ScalarType::uint8},       {"MET_CHAR", ScalarType::int8},
      {"MET_USHORT", ScalarType::uint16},     {"MET_SHORT", ScalarType::int16},
      {"MET_UINT", ScalarType::uint32},       {"MET_INT", ScalarType::int32},
      {"MET_ULONG", ScalarType::uint32},      {"MET_LONG", ScalarType::int32},
      {"MET_ULONG_LONG", ScalarType::uint64}, {"MET_LONG_LONG", ScalarType::int64},
      {"MET_FLOAT", ScalarType::float32},     {"MET_DOUBLE", ScalarType::float64}};
  for (const auto& [name, type] : types) {
    const auto path =
        dir.write("a.mha", kMetaStart + "ElementType = " + name + "\nElementDataFile = LOCAL\n" +
                               std::string(24 * size_of(type), '\x01'));
    EXPECT_EQ(info_of(path).type, type) << name;
  }
}

TEST(metaimage_reader, keeps_spacing_offset_and_the_axes_directions) {
  const TempDir dir;
  const auto path =
      dir.write("a.mha", kShort +
                             "ElementSpacing = 0.5 2 3\nOffset = 1 2 3\n"
                             "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nElementDataFile = LOCAL\n" +
                             std::string(48, 'x'));
  const RegularGrid grid = info_of(path).grid;
  EXPECT_EQ(grid.spacing, (Vec3d{{0.5, 2, 3}}));
  EXPECT_EQ(grid.direction.column(0), (Vec3d{{0, 1, 0}}));
  EXPECT_EQ(grid.to_world({{2, 1, 1}}), (Vec3d{{-1, 3, 6}}));
  EXPECT_EQ(grid.frame, Frame::unknown);
}

TEST(metaimage_reader, names_the_frame_only_where_the_header_tells_it) {
  const TempDir dir;
  const auto frame_of = [&](const std::string& orientation, const std::string& matrix) {
    return info_of(dir.write("a.mha", kShort + "AnatomicalOrientation = " + orientation +
                                          "\nTransformMatrix = " + matrix +
                                          "\nElementDataFile = LOCAL\n" + std::string(48, 'x')))
        .grid.frame;
  };
  EXPECT_EQ(frame_of("RAI", "1 0 0 0 1 0 0 0 1"), Frame::lps);
  EXPECT_EQ(frame_of("LPI", "-1 0 0 0 -1 0 0 0 1"), Frame::lps);
  EXPECT_EQ(frame_of("LPI", "1 0 0 0 1 0 0 0 1"), Frame::ras);
  EXPECT_EQ(frame_of("RAS", "1 0 0 0 1 0 0 0 1"), Frame::unknown);
  EXPECT_EQ(frame_of("\?\?\?", "1 0 0 0 1 0 0 0 1"), Frame::unknown);
}

TEST(metaimage_reader, reads_channels_and_times) {
  const TempDir dir;
  const auto all = ramp<float>(48);
  const std::string raw = bytes_of(all);
  const auto vectors = dir.write("a.mha",
                                 "NDims = 3\nDimSize = 4 3 2\nElementNumberOfChannels = 2\n"
                                 "ElementType = MET_FLOAT\nElementDataFile = LOCAL\n" +
                                     raw);
  const auto series = dir.write("b.mha",
                                "NDims = 4\nDimSize = 4 3 2 2\nElementType = MET_FLOAT\n"
                                "ElementSpacing = 1 1 1 1\nElementDataFile = LOCAL\n" +
                                    raw);
  ReadOptions options;
  options.component = 0;
  EXPECT_EQ(samples_of<float>(vectors, options).at(5), all[10]);
  ReadOptions at_time;
  at_time.time = 1;
  EXPECT_EQ(samples_of<float>(series, at_time).at(5), all[29]);
  expect_failure(series, {"2 times"});
}

TEST(metaimage_reader, refuses_truncated_data_and_bad_headers) {
  const TempDir dir;
  const std::string local = "ElementDataFile = LOCAL\n";
  const std::string raw = bytes_of(ramp<std::int16_t>(24));
  expect_failure(dir.write("a.mha", kShort + local + raw.substr(1)), {"48 bytes", "47"});
  expect_failure(dir.write("b.mha", kShort + "CompressedData = True\n" + local +
                                        test::zlibbed(raw).substr(0, 20)),
                 {"early"});
  expect_failure(dir.write("c.mha", kShort), {"ElementDataFile"});
  expect_failure(dir.write("d.mha", kMetaStart + "ElementType = MET_OTHER\n" + local),
                 {"MET_OTHER"});
  expect_failure(dir.write("e.mha", "NDims = 3\nDimSize = 4 3\nElementType = MET_CHAR\n" + local),
                 {"3 numbers for DimSize", "'4 3'"});
  expect_failure(dir.write("f.mha",
                           "NDims = 3\nDimSize = 2000000000 2000000000 2000000000\n"
                           "ElementType = MET_DOUBLE\n" +
                               local),
                 {"2^63"});
  expect_failure(dir.write("g.mha", kShort + "ElementSpacing = 1 0 1\n" + local + raw),
                 {"spacing along axis y"});
  expect_failure(dir.write("h.mha", kShort + "TransformMatrix = 1 0 0 1 0 0 0 0 1\n" + local + raw),
                 {"independent"});
  expect_failure(dir.write("i.mha", std::string(3000, '\x02')), {"Name = value"});
  expect_failure(dir.write("j.mhd", kShort + "ElementDataFile = slice%03d.raw 1 9 1\n"),
                 {"one ElementDataFile"});
  expect_failure(dir.write("k.mha", kShort + "HeaderSize = 9000000000000000000\n" + local + raw),
                 {"HeaderSize"});
}

}  // namespace
}  // namespace lode::io
