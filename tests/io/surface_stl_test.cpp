#include <gtest/gtest.h>

#include <cstring>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

Surface make_tetrahedron() {
  Surface surface;
  surface.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
  surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return surface;
}

TEST(stl_file, has_fifty_bytes_a_triangle_and_outward_facet_normals) {
  const std::string path = temporary_path("bytes.stl");
  expect_written(path, make_tetrahedron(), {.comment = std::string(200, 'c')});
  const std::string bytes = bytes_of(path);
  ::unlink(path.c_str());
  ASSERT_EQ(bytes.size(), 84U + 4 * 50);
  EXPECT_FALSE(bytes.starts_with("solid"));
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, sizeof(n));
  EXPECT_EQ(n, 4U);
  Vec3f normal;
  std::memcpy(&normal, bytes.data() + 84, sizeof(normal));
  EXPECT_EQ(normal, (Vec3f{{0, 0, -1}}));
}

TEST(stl_file, has_a_header_without_half_a_number) {
  const std::string path = temporary_path("header.stl");
  const auto header_of = [&](const std::string& comment) {
    Progress progress;
    EXPECT_TRUE(write_surface(path, make_tetrahedron(), {.comment = comment}, progress));
    std::string header = bytes_of(path).substr(0, 80);
    return header.substr(0, header.find_last_not_of(' ') + 1);
  };
  EXPECT_EQ(header_of("Lode: isovalue 5e-07, max_error 1e-9"),
            "binary STL, Lode: isovalue 5e-07, max_error 1e-9");
  EXPECT_EQ(header_of("Lode: isovalue 512.3456789012, max_error 1.2345678901234567e-11, more 1"),
            "binary STL, Lode: isovalue 512.3456789012, max_error 1.2345678901234567e-11");
  EXPECT_EQ(header_of("Lode: isovalue 512.3456789012345, max_error 1.234567890123456789e-111"),
            "binary STL, Lode: isovalue 512.3456789012345");
  EXPECT_EQ(header_of(std::string(200, 'x')), "binary STL");
  ::unlink(path.c_str());
}

TEST(stl_file, merges_corners_that_are_equal_and_no_others) {
  const Surface read = written_and_read(".stl", make_tetrahedron());
  EXPECT_EQ(read.positions.size(), 4U);
  EXPECT_EQ(read.triangles.size(), 4U);
  Surface near = make_tetrahedron();
  near.positions.push_back({{std::nextafter(1.0F, 2.0F), 0, 0}});
  near.triangles.push_back({0, 4, 1});
  near.positions.push_back({{-0.0F, 0, 0}});
  near.triangles.push_back({5, 4, 1});
  EXPECT_EQ(written_and_read(".stl", near).positions.size(), 5U);
}

TEST(stl_file, reads_ascii) {
  const std::string facet =
      "  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n      vertex 1e0 0 0\n"
      "      vertex 0 +1 0.1\n    endloop\n  endfacet\n";
  const Result<Surface> read =
      read_bytes(".stl", "solid some name\n" + facet + facet + "endsolid some name\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().positions.size(), 3U);
  EXPECT_EQ(read.value().positions[2], (Vec3f{{0, 1, 0.1F}}));
  EXPECT_EQ(read.value().triangles.size(), 2U);
}

TEST(stl_file, refuses_cut_or_wrong_ascii) {
  const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
  EXPECT_NE(complaint_about(".stl", "solid a\n" + facet), "");
  EXPECT_NE(complaint_about(".stl", "solid a\n" + facet + "endloop\nendfacet\nendsolid\n"), "");
  EXPECT_NE(complaint_about(".stl", "solid a\n" + facet + "vertex 0 1 z\n"), "");
  EXPECT_EQ(complaint_about(".stl", "solid a\nendsolid a\n"), "");
}

TEST(stl_file, reads_binary_files_that_start_with_solid) {
  const std::string path = temporary_path("solid.stl");
  expect_written(path, make_tetrahedron());
  std::string bytes = bytes_of(path);
  ::unlink(path.c_str());
  bytes.replace(0, 5, "solid");
  const Result<Surface> read = read_bytes(".stl", bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().triangles.size(), 4U);
}

TEST(stl_file, refuses_coordinates_that_are_not_finite) {
  Surface surface = make_tetrahedron();
  surface.positions[0][0] = std::numeric_limits<float>::infinity();
  const std::string path = temporary_path("infinite.stl");
  expect_written(path, surface);
  EXPECT_FALSE(read_surface(path));
  ::unlink(path.c_str());
}

}  // namespace
}  // namespace lode::io
