#include <gtest/gtest.h>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

TEST(obj_file, reads_all_forms_of_corners) {
  const Result<Surface> read = read_bytes(
      ".obj",
      "# made by hand\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 # far corner\r\n"
      "v 0 1 0 0.5 0.5 0.5\nvt 0 0\ng part\nusemtl m\ns off\n"
      "f 1 2 3 4\nf 1/1 2/1 3/1\nf -4 -3 -2\n");
  ASSERT_TRUE(read) << read.error().message;
  const Surface& surface = read.value();
  EXPECT_EQ(surface.positions.size(), 4U);
  ASSERT_EQ(surface.triangles.size(), 4U);
  EXPECT_EQ(surface.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(surface.triangles[2], surface.triangles[0]);
  EXPECT_EQ(surface.triangles[3], surface.triangles[0]);
  EXPECT_TRUE(surface.normals.empty());
}

TEST(obj_file, keeps_normals_where_each_vertex_has_one) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 1 0 0\n";
  const Result<Surface> shared = read_bytes(".obj", points + "f 1//1 2//1 3/9/2\n");
  ASSERT_TRUE(shared) << shared.error().message;
  const Vec3f up{{0, 0, 1}};
  EXPECT_EQ(shared.value().normals, (std::vector<Vec3f>{up, up, {{1, 0, 0}}}));
  const Result<Surface> in_conflict =
      read_bytes(".obj", points + "f 1//1 2//1 3//1\nf 1//2 2//1 3//1\n");
  ASSERT_TRUE(in_conflict);
  EXPECT_TRUE(in_conflict.value().normals.empty());
  EXPECT_NE(complaint_about(".obj", points + "f 1//1 2//1 3//0\n"), "");
}

TEST(obj_file, reads_polylines_as_segments) {
  const Result<Surface> read = read_bytes(".obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3/7 1\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().lines,
            (std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {1, 2}, {2, 0}}));
}

TEST(obj_file, gives_foreign_coordinates_far_from_zero_an_origin) {
  const Result<Surface> read =
      read_bytes(".obj", "v 500000.125 4649776.01 7\nv 500001.125 4649777.01 8\n");
  ASSERT_TRUE(read);
  EXPECT_EQ(read.value().origin, (Vec3d{{500000.125, 4649776.01, 7}}));
  EXPECT_EQ(read.value().positions[1], (Vec3f{{1, 1, 1}}));
  const Result<Surface> near = read_bytes(".obj", "v 0.1 0.2 7\nv 1.1 1.2 8\n");
  ASSERT_TRUE(near);
  EXPECT_EQ(near.value().origin, Vec3d{});
  EXPECT_EQ(near.value().positions[0], (Vec3f{{0.1F, 0.2F, 7}}));
}

TEST(obj_file, refuses_numbers_that_are_none_and_vertices_that_are_missing) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* bad : {"f 1 2 4", "f 1 2 0", "f 1 2 -4", "f 1 2", "f 1 2 x",
                          "f 1 2 3//9999999999", "f 1 2 99999999999999999999", "v 1 2", "v 1 2 z",
                          "vn 1 2", "v 1 2 1e999", "v nan 0 0", "f 1 2 3\nl 1 2"})
    EXPECT_NE(complaint_about(".obj", points + bad), "") << bad;
  EXPECT_NE(complaint_about(".obj", points + "f 1 2 x").find("line 4"), std::string::npos);
}

TEST(obj_file, is_text_with_the_shortest_exact_digits) {
  Surface surface;
  surface.positions = {{{0.1F, 1, 1e-7F}}, {{1, 0, 0}}, {{0, 1, 0}}};
  surface.normals.assign(3, {{0, 0, 1}});
  surface.triangles = {{0, 1, 2}};
  const std::string path = temporary_path("bytes.obj");
  expect_written(path, surface, {.comment = "made\rhere", .frame = Frame::lps});
  EXPECT_EQ(bytes_of(path),
            "# made here\n# frame LPS\n# lode_origin 0 0 0\nv 0.1 1 1e-07\nv 1 0 0\nv 0 1 0\n"
            "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//2 3//3\n");
}

}  // namespace
}  // namespace lode::io
