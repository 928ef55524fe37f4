// VTK, which shares no code with Lode, reads the meshes that Lode writes.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "lode/io/mesh_vtu.h"
#include "lode/io/surface_file.h"
#include "tests/io/vtk_oracle.h"

namespace lode::io {
namespace {

std::string mesh_path(const std::string& name) {
  return testing::TempDir() + "lode_mesh_" + std::to_string(::getpid()) + "_" + name;
}

/// A cube of side 2 in six tetrahedra round its diagonal, at an offset no float32 holds.
SimplexMesh make_cube() {
  SimplexMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({{1e7 + 0.1 + 2 * (i & 1), 2.0 * ((i >> 1) & 1), 2.0 * (i >> 2)}});
    mesh.values.push_back(0.1 + i);
  }
  for (const auto& [a, b] : {std::pair{1U, 3U}, {3U, 2U}, {2U, 6U}, {6U, 4U}, {4U, 5U}, {5U, 1U}})
    mesh.tetrahedra.push_back({0U, a, b, 7U});
  for (std::size_t i = 0; i < 6; ++i) mesh.errors.push_back(0.5F * static_cast<float>(i));
  return mesh;
}

nlohmann::json seen_by_vtk(const std::string& path) {
  const std::string output = test::run_oracle(LODE_MESH_ORACLE, path);
  return nlohmann::json::parse(output, nullptr, false);
}

nlohmann::json written_and_seen(const SimplexMesh& mesh, const MeshWriteOptions& options) {
  const std::string path = mesh_path("m.vtu");
  Progress progress;
  const auto status = write_vtu(path, mesh, options, progress);
  EXPECT_TRUE(status) << status.error().message;
  nlohmann::json seen = seen_by_vtk(path);
  ::unlink(path.c_str());
  return seen;
}

TEST(mesh_vtu, is_read_by_vtk_to_the_last_digit) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const nlohmann::json seen = written_and_seen(
      make_cube(), {.comment = "a -- <cube>", .frame = Frame::lps, .value_name = "density"});
  EXPECT_EQ(seen.at("points"), 8);
  EXPECT_EQ(seen.at("cells"), 6);
  EXPECT_EQ(seen.at("types"), nlohmann::json{10});
  EXPECT_NEAR(seen.at("size").get<double>(), 8, 1e-7);  // an ulp of 1e7 is 2e-9
  EXPECT_GT(seen.at("smallest").get<double>(), 1.3);
  EXPECT_EQ(seen.at("bounds")[0], 1e7 + 0.1);
  EXPECT_EQ(seen.at("scalars"), "density");
  const auto& values = seen.at("point_data").at("density");
  EXPECT_EQ(values.at("type"), "double");
  EXPECT_EQ(values.at("range"), (nlohmann::json{0.1, 7.1}));
  const auto& errors = seen.at("cell_data").at("error");
  EXPECT_EQ(errors.at("type"), "float");
  EXPECT_EQ(errors.at("tuples"), 6);
  EXPECT_EQ(errors.at("range"), (nlohmann::json{0, 2.5}));
}

TEST(mesh_vtu, holds_narrow_values_and_triangles_and_nothing) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  SimplexMesh mesh;
  mesh.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}};
  mesh.values = {1, 2, 3, 4};
  mesh.has_narrow_values = true;
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.errors = {0, 1};
  nlohmann::json seen = written_and_seen(mesh, {.value_name = "isovalue"});
  EXPECT_EQ(seen.at("types"), nlohmann::json{5});
  EXPECT_EQ(seen.at("size"), 1);
  EXPECT_EQ(seen.at("scalars"), "value");
  EXPECT_EQ(seen.at("point_data").at("value").at("type"), "float");
  seen = written_and_seen({}, {.value_name = "a <\"b\"> & c"});
  EXPECT_EQ(seen.at("points"), 0);
  EXPECT_EQ(seen.at("cells"), 0);
}

TEST(mesh_vtu, leaves_nothing_when_it_is_cancelled_or_has_no_place) {
  Progress progress;
  progress.cancel();
  const std::string path = mesh_path("cancelled.vtu");
  EXPECT_FALSE(write_vtu(path, make_cube(), {}, progress));
  EXPECT_FALSE(std::filesystem::exists(path));
  Progress other;
  EXPECT_FALSE(write_vtu("/nonexistent/x.vtu", make_cube(), {}, other));
  EXPECT_TRUE(check_mesh_path("a.VTU"));
  EXPECT_FALSE(check_mesh_path(".vtu"));
  EXPECT_FALSE(check_mesh_path("a.vtp"));
}

TEST(surface_values, are_read_by_vtk_and_do_not_disturb_our_readers) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  Surface section;
  section.positions = {{{0, 0, 0}}, {{2, 0, 0}}, {{2, 2, 0}}, {{0, 2, 0}}};
  section.values = {0.1, 1e300, 3, -4};
  section.triangles = {{0, 1, 2}, {0, 2, 3}};
  section.errors = {0.25F, 1};
  Progress progress;
  for (const char* name : {"s.vtp", "s.ply", "s.obj", "s.stl", "s.glb"}) {
    const std::string path = mesh_path(name);
    EXPECT_EQ(can_hold_values(path), path.ends_with(".vtp") || path.ends_with(".ply"));
    ASSERT_TRUE(write_surface(path, section, {.value_name = "density"}, progress));
    const auto read = read_surface(path);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->positions, section.positions);
    EXPECT_EQ(read->triangles, section.triangles);
    if (path.ends_with(".vtp")) {
      const nlohmann::json seen = seen_by_vtk(path);
      EXPECT_EQ(seen.at("size"), 4);
      EXPECT_EQ(seen.at("scalars"), "density");
      EXPECT_EQ(seen.at("point_data").at("density").at("range"), (nlohmann::json{-4, 1e300}));
      EXPECT_EQ(seen.at("cell_data").at("error").at("range"), (nlohmann::json{0.25, 1}));
    }
    ::unlink(path.c_str());
  }
}

TEST(surface_values, go_with_lines_too) {
  Surface lines;
  lines.positions = {{{0, 0, 0}}, {{2, 0, 0}}, {{2, 2, 0}}};
  lines.isovalues = {1, 1, 1};
  lines.lines = {{0, 1}, {1, 2}};
  lines.errors = {0.25F, 1};
  Progress progress;
  for (const char* name : {"l.vtp", "l.ply"}) {
    const std::string path = mesh_path(name);
    ASSERT_TRUE(write_surface(path, lines, {}, progress));
    const auto read = read_surface(path);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->lines, lines.lines);
    EXPECT_EQ(read->isovalues, lines.isovalues);
    ::unlink(path.c_str());
  }
}

}  // namespace
}  // namespace lode::io
