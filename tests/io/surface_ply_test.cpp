#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

template <typename T>
void append(std::string& bytes, T value, bool is_big_endian) {
  std::string part(sizeof(T), '\0');
  std::memcpy(part.data(), &value, sizeof(T));
  if (is_big_endian) std::reverse(part.begin(), part.end());
  bytes += part;
}

/// A square with a colour per vertex, an unknown element and a quad, as other programs write it.
std::string binary_square(bool is_big_endian) {
  std::string bytes = std::string("ply\nformat binary_") + (is_big_endian ? "big" : "little") +
                      "_endian 1.0\ncomment x\nobj_info y\nelement camera 1\nproperty double f\n"
                      "element vertex 4\nproperty uchar red\nproperty double x\n"
                      "property float32 y\nproperty short z\nelement face 1\n"
                      "property list uint8 float weights\n"
                      "property list ushort int32 vertex_index\nend_header\n";
  append(bytes, 1.5, is_big_endian);
  for (int i = 0; i < 4; ++i) {
    bytes += 'r';
    append(bytes, i % 2 + 0.5, is_big_endian);
    append(bytes, static_cast<float>(i / 2), is_big_endian);
    append(bytes, std::int16_t{-7}, is_big_endian);
  }
  append(bytes, std::uint8_t{2}, is_big_endian);
  append(bytes, 1.0F, is_big_endian);
  append(bytes, 2.0F, is_big_endian);
  append(bytes, std::uint16_t{4}, is_big_endian);
  for (const std::int32_t vertex : {0, 1, 3, 2}) append(bytes, vertex, is_big_endian);
  return bytes;
}

void expect_square(const Result<Surface>& square) {
  ASSERT_TRUE(square) << square.error().message;
  const Surface& surface = square.value();
  ASSERT_EQ(surface.positions.size(), 4U);
  EXPECT_EQ(surface.positions[3], (Vec3f{{1.5F, 1, -7}}));
  ASSERT_EQ(surface.triangles.size(), 2U);
  EXPECT_EQ(surface.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 3}));
  EXPECT_EQ(surface.triangles[1], (std::array<std::uint32_t, 3>{0, 3, 2}));
}

std::string ascii_ply(std::string_view elements, std::string_view data) {
  return "ply\nformat ascii 1.0\n" + std::string(elements) + "end_header\n" + std::string(data);
}

constexpr std::string_view kPoints =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
constexpr std::string_view kFace = "element face 1\nproperty list uchar int vertex_indices\n";

TEST(ply_file, reads_either_byte_order_and_skips_what_it_does_not_know) {
  expect_square(read_bytes(".ply", binary_square(false)));
  expect_square(read_bytes(".ply", binary_square(true)));
}

TEST(ply_file, reads_ascii_with_crlf_and_rounds_floats_once) {
  const std::string header =
      "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\n"
      "property float y\r\nproperty float z\r\nproperty float isovalue\r\n"
      "element face 1\r\nproperty list uchar int vertex_indices\r\n"
      "end_header\r\n";
  const Result<Surface> read =
      read_bytes(".ply", header + "0.1 0 0 7\r\n1 0 1e-60 7\r\n0 1 -0.3 8\r\n3 0 1 2");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().positions[0][0], 0.1F);
  EXPECT_EQ(read.value().positions[1][2], 0.0F);
  EXPECT_EQ(read.value().isovalues, (std::vector<double>{7, 7, 8}));
  EXPECT_EQ(read.value().triangles.size(), 1U);
}

TEST(ply_file, writes_the_documented_bytes) {
  Surface surface;
  surface.positions = {{{1, 2, 3}}, {{4, 5, 6}}, {{7, 8, 9}}};
  surface.isovalues = {10, 11, 12};
  surface.triangles = {{0, 1, 2}};
  const std::string path = temporary_path("bytes.ply");
  expect_written(path, surface, {.comment = "two\nlines", .frame = Frame::ras});
  std::string expected =
      "ply\nformat binary_little_endian 1.0\ncomment two lines\ncomment frame RAS\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property double isovalue\nelement face 1\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  for (int i = 0; i < 3; ++i) {
    for (int k = 1; k <= 3; ++k) append(expected, static_cast<float>(3 * i + k), false);
    append(expected, static_cast<double>(10 + i), false);
  }
  expected += '\3';
  for (const std::uint32_t vertex : {0U, 1U, 2U}) append(expected, vertex, false);
  EXPECT_EQ(bytes_of(path), expected);
}

TEST(ply_file, gives_foreign_double_coordinates_an_origin_only_where_float_needs_one) {
  const std::string header =
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n";
  const Result<Surface> exact =
      read_bytes(".ply", ascii_ply(header, "4000000.25 0 0\n1 2 3\n4 5 6\n"));
  ASSERT_TRUE(exact);
  EXPECT_EQ(exact.value().origin, Vec3d{});
  const Result<Surface> far =
      read_bytes(".ply", ascii_ply(header, "500000.1 7 0\n500001.1 8 0\n500003.1 9 1\n"));
  ASSERT_TRUE(far);
  EXPECT_EQ(far.value().origin, (Vec3d{{500000.1, 7, 0}}));
  EXPECT_EQ(far.value().positions[2], (Vec3f{{3, 2, 1}}));
}

TEST(ply_file, ignores_an_origin_note_that_no_longer_fits) {
  const std::string text = "ply\nformat ascii 1.0\ncomment lode_origin 1e30 0 0\n" +
                           std::string(kPoints) + "end_header\n0 0 0\n1 0 0\n0 1 0\n";
  const Result<Surface> read = read_bytes(".ply", text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().origin, Vec3d{});
}

TEST(ply_file, refuses_counts_larger_than_the_file) {
  for (const char* count : {"1000000000000", "18446744073709551615", "4"}) {
    const std::string vertices = std::string("element vertex ") + count +
                                 "\nproperty float x\nproperty float y\nproperty float z\n";
    EXPECT_NE(complaint_about(".ply", ascii_ply(vertices, "0 0 0 1 1 1 2 2 2")), "");
  }
  EXPECT_EQ(complaint_about(".ply", ascii_ply("element nothing 18446744073709551615\n", "")), "");
  const std::string face = std::string(kPoints) + std::string(kFace);
  EXPECT_NE(complaint_about(".ply", ascii_ply(face, "0 0 0 1 0 0 0 1 0 4000000000 0 1 2")), "");
}

TEST(ply_file, refuses_bad_faces_and_coordinates) {
  const std::string face = std::string(kPoints) + std::string(kFace);
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  for (const char* bad : {"3 0 1 3", "3 0 1 -1", "3 0 1 0.5", "2 0 1", "3 0 1 x"})
    EXPECT_NE(complaint_about(".ply", ascii_ply(face, points + bad)), "") << bad;
  EXPECT_EQ(complaint_about(".ply", ascii_ply(face, points + "3 0 1 2")), "");
  EXPECT_NE(complaint_about(".ply", ascii_ply(kPoints, "nan 0 0 1 0 0 0 1 0")), "");
  EXPECT_NE(complaint_about(".ply", ascii_ply(kPoints, "inf 0 0 1 0 0 0 1 0")), "");
  EXPECT_NE(complaint_about(".ply", ascii_ply(kPoints, "1e99 0 0 1 0 0 0 1 0")), "");
}

TEST(ply_file, refuses_headers_that_are_none) {
  EXPECT_NE(complaint_about(".ply", "ply\nend_header\n"), "");
  EXPECT_NE(complaint_about(".ply", "ply\nformat ebcdic 1.0\nend_header\n"), "");
  EXPECT_NE(complaint_about(".ply", "ply\nformat ascii 1.0\nelement vertex -3\nend_header\n"), "");
  EXPECT_NE(complaint_about(".ply", ascii_ply("element vertex 1\nproperty flute x\n", "0")), "");
  EXPECT_NE(complaint_about(".ply", ascii_ply("element vertex 1\nproperty float x\n", "0")), "");
  EXPECT_NE(complaint_about(".ply", ascii_ply("element tristrips 1\nproperty int x\n", "0")), "");
}

}  // namespace
}  // namespace lode::io
