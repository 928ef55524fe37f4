// Readers that share no code with Lode, and Lode's own, see in meshes what was written to them.
#include "lode/io/mesh_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "lode/io/mesh_blocks.h"
#include "lode/io/mesh_reader.h"
#include "lode/io/netcdf_output.h"
#include "lode/io/tetrahedra.h"
#include "tests/io/vtk_oracle.h"

namespace lode::io {
namespace {

using nlohmann::json;

/// A cell's corners, error and region, as text that sorts.
using CellRow = std::tuple<std::vector<std::uint32_t>, double, double>;

std::string file_path(const std::string& name) {
  return testing::TempDir() + "lode_mesh_file_" + std::to_string(::getpid()) + "_" + name;
}

/// A strip of 5 cubes, each in six tetrahedra, far enough from 0 that floats would round it, whose
/// regions alternate.
SimplexMesh strip(const std::vector<std::int64_t>& regions) {
  SimplexMesh mesh;
  for (int i = 0; i < 24; ++i) {
    const int x = i / 4;
    mesh.positions.push_back({{1e7 + 0.1 + 2 * x, 2.0 * (i & 1), 0.5 * (i / 2 % 2)}});
    mesh.values.push_back(0.1 + i);
  }
  for (std::uint32_t x = 0; x < 5; ++x) {
    const auto corner = [x](std::uint32_t i) { return 4 * (x + (i & 1U)) + (i >> 1U); };
    for (const auto& [a, b] : {std::pair{1U, 3U}, {3U, 2U}, {2U, 6U}, {6U, 4U}, {4U, 5U}, {5U, 1U}})
      mesh.tetrahedra.push_back({corner(0), corner(a), corner(b), corner(7)});
  }
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    mesh.errors.push_back(0.5F * static_cast<float>(i) + 0.1F);
    if (!regions.empty()) mesh.regions.push_back(regions[i % regions.size()]);
  }
  return mesh;
}

std::vector<CellRow> rows_of(const SimplexMesh& mesh) {
  std::vector<CellRow> rows;
  for (std::size_t i = 0; i < mesh.n_cells(); ++i) {
    std::vector<std::uint32_t> corners;
    if (mesh.triangles.empty())
      corners.assign(mesh.tetrahedra[i].begin(), mesh.tetrahedra[i].end());
    else
      corners.assign(mesh.triangles[i].begin(), mesh.triangles[i].end());
    rows.emplace_back(corners, mesh.errors[i],
                      mesh.regions.empty() ? 0 : static_cast<double>(mesh.regions[i]));
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

std::vector<CellRow> rows_of(const json& seen) {
  std::vector<CellRow> rows;
  for (const json& cell : seen.at("cells"))
    rows.emplace_back(cell[0].get<std::vector<std::uint32_t>>(), cell[1].get<double>(),
                      cell[2].is_null() ? 0 : cell[2].get<double>());
  std::sort(rows.begin(), rows.end());
  return rows;
}

class mesh_formats : public testing::TestWithParam<const char*> {
 protected:
  ~mesh_formats() override { ::unlink(path_.c_str()); }

  void write(const SimplexMesh& mesh, const MeshWriteOptions& options) {
    Progress progress;
    const auto status = write_mesh(path_, mesh, options, progress);
    ASSERT_TRUE(status) << status.error().message;
  }
  [[nodiscard]] json seen() const {
    const std::string output = test::run_oracle(LODE_MESH_CONTENT, path_);
    json read = json::parse(output, nullptr, false);
    EXPECT_TRUE(read.is_object()) << output;
    return read;
  }
  [[nodiscard]] bool is_exodus() const { return std::string(GetParam()).starts_with(".e"); }
  [[nodiscard]] bool has_blocks() const { return std::string(GetParam()) != ".vtk"; }

  std::string path_ = file_path(std::string("m") + GetParam());
};

void expect_same(const json& seen, const SimplexMesh& mesh, const std::string& name) {
  EXPECT_EQ(seen.at("points"), json(std::vector<std::array<double, 3>>([&] {
              std::vector<std::array<double, 3>> points;
              for (const Vec3d& p : mesh.positions) points.push_back(p.v);
              return points;
            }())));
  ASSERT_EQ(seen.at("values").size(), 1U);
  EXPECT_EQ(seen.at("values").at(name), json(mesh.values));
  EXPECT_EQ(rows_of(seen), rows_of(mesh));
}

TEST_P(mesh_formats, hold_points_cells_values_errors_and_regions_to_the_last_digit) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const SimplexMesh mesh = strip({40, 7, 2000000000});
  write(mesh, {.comment = "a $End <cube>\n", .frame = Frame::lps, .value_name = "von Mises (psi)"});
  const json read = seen();
  expect_same(read, mesh, "von Mises (psi)");
  EXPECT_NE(read.at("title").get<std::string>().find("; frame LPS"), std::string::npos);
  if (!has_blocks()) return;
  for (const json& cell : read.at("cells"))
    EXPECT_EQ(cell[3], "region " + std::to_string(cell[2].get<int>()));
  if (is_exodus()) EXPECT_EQ(read.at("ids"), json({7, 40, 2000000000}));
}

/// Two further fields, with and without errors.
SimplexMesh strip_of_three_fields() {
  SimplexMesh mesh = strip({3, 1});
  mesh.attributes.resize(2);
  mesh.attributes[0].name = "heat";
  mesh.attributes[0].is_narrow = true;
  mesh.attributes[1].name = "flow";
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    mesh.attributes[0].values.push_back(0.25 * static_cast<double>(v));
    mesh.attributes[1].values.push_back(1.0 / static_cast<double>(v + 1));
  }
  for (std::size_t i = 0; i < mesh.n_cells(); ++i)
    mesh.attributes[0].errors.push_back(1 / static_cast<float>(i + 1));
  return mesh;
}

void expect_three_fields(const json& read, const SimplexMesh& mesh) {
  EXPECT_EQ(read.at("values").size(), 3U);
  EXPECT_EQ(read.at("values").at("wave"), json(mesh.values));
  for (const Attribute& attribute : mesh.attributes)
    EXPECT_EQ(read.at("values").at(attribute.name), json(attribute.values));
  ASSERT_EQ(read.at("errors").size(), 1U);
  const json& errors = read.at("errors").at("error_heat");
  ASSERT_EQ(errors.size(), mesh.n_cells());
  // Cells may be in another order: "error" says which is which.
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const auto number = static_cast<std::size_t>(2 * read.at("cells")[i][1].get<double>());
    EXPECT_EQ(errors[i], json(static_cast<double>(mesh.attributes[0].errors.at(number))));
  }
}

TEST_P(mesh_formats, hold_further_fields_and_their_errors) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const SimplexMesh mesh = strip_of_three_fields();
  write(mesh, {.value_name = "wave"});
  const json read = seen();
  expect_three_fields(read, mesh);
  EXPECT_EQ(rows_of(read), rows_of(mesh));
}

TEST(mesh_exodus, has_vectors_by_names_that_readers_join) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  SimplexMesh mesh = strip({3, 1});
  json vectors = json::array();
  mesh.attributes.resize(3);
  for (std::size_t i = 0; i < 3; ++i) mesh.attributes[i].name = fmt::format("flow:{}", i);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i)
      mesh.attributes[i].values.push_back(static_cast<double>(4 * v + i));
    vectors.push_back({4.0 * static_cast<double>(v), 4.0 * static_cast<double>(v) + 1,
                       4.0 * static_cast<double>(v) + 2});
  }
  const std::string path = file_path("vectors.e");
  Progress progress;
  ASSERT_TRUE(write_mesh(path, mesh, {.value_name = "wave"}, progress));
  const json read = json::parse(test::run_oracle(LODE_MESH_CONTENT, path), nullptr, false);
  ASSERT_TRUE(read.is_object());
  ASSERT_EQ(read.at("values").size(), 2U) << read.at("values").dump();
  EXPECT_EQ(read.at("values").at("flow_"), vectors);
  ::unlink(path.c_str());
}

TEST(mesh_vtu, holds_further_fields_and_their_errors) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const SimplexMesh mesh = strip_of_three_fields();
  const std::string path = file_path("fields.vtu");
  Progress progress;
  ASSERT_TRUE(write_mesh(path, mesh, {.value_name = "wave"}, progress));
  const json read = json::parse(test::run_oracle(LODE_MESH_CONTENT, path), nullptr, false);
  ASSERT_TRUE(read.is_object());
  expect_three_fields(read, mesh);
  EXPECT_EQ(rows_of(read), rows_of(mesh));
  ::unlink(path.c_str());
}

/// A strip with two patches, of all that lies at both ends; counts what has no patch, too.
SimplexMesh strip_with_patches() {
  SimplexMesh mesh = strip({2, 6});
  mesh.patches = {{3, "in \"let\" $End"}, {70, ""}, {80, "of no face"}};
  for (std::uint32_t cell = 0; cell < mesh.tetrahedra.size(); ++cell)
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const auto face = face_across(mesh.tetrahedra[cell], corner);
      const auto lies_at = [&](double x) {
        return std::all_of(face.begin(), face.end(),
                           [&](std::uint32_t v) { return mesh.positions[v][0] == x; });
      };
      if (lies_at(mesh.positions.front()[0])) mesh.patch_sides.push_back({cell, corner, 0});
      if (lies_at(mesh.positions.back()[0])) mesh.patch_sides.push_back({cell, corner, 1});
    }
  return mesh;
}

/// By name: corners, from whichever on.
std::map<std::string, std::set<std::vector<std::uint32_t>>> patches_of(const SimplexMesh& mesh) {
  std::map<std::string, std::set<std::vector<std::uint32_t>>> patches;
  for (const PatchSide& side : mesh.patch_sides) {
    const auto face = mesh.corners_of(side);
    std::vector<std::uint32_t> corners(face.begin(), face.end());
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    patches[name_of(mesh.patches[side.patch])].insert(corners);
  }
  return patches;
}

TEST_P(mesh_formats, hold_patches) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const SimplexMesh mesh = strip_with_patches();
  ASSERT_EQ(mesh.patch_sides.size(), 4U);
  write(mesh, {.value_name = "wave"});
  const json read = seen();
  expect_same(read, mesh, "wave");
  std::map<std::string, std::set<std::vector<std::uint32_t>>> found;
  for (const auto& [name, faces] : read.at("patches").items())
    for (std::vector<std::uint32_t> corners : faces) {
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      found[name].insert(corners);
    }
  auto expected = patches_of(mesh);
  const std::string format = GetParam();
  if (format == ".vtk") {
    expected = {{"3", expected.begin()->second}, {"70", std::prev(expected.end())->second}};
  } else if (format == ".msh") {
    auto named = expected.extract(mesh.patches[0].name);
    named.key() = "in _let_ _End";
    expected.insert(std::move(named));
  }
  EXPECT_EQ(found, expected);
}

TEST_P(mesh_formats, tell_patches_of_one_name_apart) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  SimplexMesh mesh = strip_with_patches();
  mesh.patches[0].name = mesh.patches[1].name = std::string(300, 'x');
  write(mesh, {.value_name = "wave"});
  std::size_t n = 0;
  const json patches = seen().at("patches");
  for (const auto& [name, faces] : patches.items()) n += faces.size();
  EXPECT_EQ(n, 4U);
}

TEST_P(mesh_formats, have_patches_that_lode_reads_but_for_exodus) {
  if (is_exodus()) return;
  SimplexMesh mesh = strip_with_patches();
  mesh.patches[0].name = "inlet";
  write(mesh, {.value_name = "wave"});
  auto cells = read_cell_mesh(path_, {});
  ASSERT_TRUE(cells) << cells.error().message;
  const auto made = to_tetrahedra(std::move(*cells), {});
  ASSERT_TRUE(made) << made.error().message;
  const bool has_names = std::string(GetParam()) != ".vtk";
  ASSERT_EQ(made->mesh.patches.size(), 2U);
  EXPECT_EQ(made->mesh.patches[0], (BoundaryPatch{3, has_names ? "inlet" : ""}));
  EXPECT_EQ(made->mesh.patches[1].id, 70);
  EXPECT_EQ(made->mesh.patch_faces.size(), 4U);
  EXPECT_EQ(made->report.n_lower_cells, 0U);
  for (const PatchFace& face : made->mesh.patch_faces)
    for (const std::uint32_t v : face.corners)
      EXPECT_EQ(made->mesh.positions[v][0],
                (face.patch == 0 ? mesh.positions.front() : mesh.positions.back())[0]);
}

TEST_P(mesh_formats, hold_the_time_of_a_step) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const SimplexMesh mesh = strip({3, 5});
  write(mesh, {.value_name = "wave", .time = 0.1});
  const json read = seen();
  expect_same(read, mesh, "wave");
  EXPECT_EQ(read.at("time"), 0.1);
  if (!is_exodus()) EXPECT_EQ(read_cell_mesh(path_, {})->time, 0.1);
  // Exodus and Gmsh have one always.
  write(mesh, {.value_name = "wave"});
  EXPECT_EQ(seen().at("time"), std::string(GetParam()) == ".vtk" ? json(nullptr) : json(0.0));
}

TEST_P(mesh_formats, hold_names_of_regions) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  SimplexMesh mesh = strip({3, 5, 8, 9});
  mesh.region_names = {{3, "ro\"tor\" $End"}, {5, "air"}, {8, "air"}, {12, "of no cell"}};
  write(mesh, {.value_name = "wave"});
  const json read = seen();
  expect_same(read, mesh, "wave");
  if (!has_blocks()) return;
  const bool is_gmsh = std::string(GetParam()) == ".msh";
  const std::map<int, std::string> names{{3, is_gmsh ? "ro_tor_ _End" : "ro\"tor\" $End"},
                                         {5, "air"},
                                         {8, "air (8)"},
                                         {9, "region 9"}};
  std::map<int, std::string> found;
  const bool has_ids = !read.at("cells")[0][2].is_null();
  std::set<std::string> all;
  for (const json& cell : read.at("cells")) {
    all.insert(cell[3].get<std::string>());
    if (has_ids) found[cell[2].get<int>()] = cell[3].get<std::string>();
  }
  if (has_ids) EXPECT_EQ(found, names);
  std::set<std::string> expected;
  for (const auto& [id, name] : names) expected.insert(name);
  EXPECT_EQ(all, expected);
}

/// By number, of regions of these names.
std::vector<std::string> block_names(const std::vector<std::string>& names) {
  std::vector<std::int64_t> ids;
  for (std::size_t i = 0; i < names.size(); ++i) ids.push_back(static_cast<std::int64_t>(i) + 3);
  SimplexMesh mesh = strip(ids);
  for (std::size_t i = 0; i < names.size(); ++i) mesh.region_names.push_back({ids[i], names[i]});
  std::vector<std::string> made;
  const MeshBlocks blocks(mesh);
  for (const MeshBlock& block : blocks.blocks()) made.push_back(block.name);
  return made;
}

TEST(mesh_blocks, have_names_of_their_own_though_those_with_numbers_are_taken) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(block_names({"a", "a (5)", "a"}), (Names{"a", "a (5)", "a (5) (5)"}));
  EXPECT_EQ(block_names({"a", "a", "a (4)"}), (Names{"a", "a (4)", "a (4) (5)"}));
  EXPECT_EQ(block_names({"a", "a (6)", "a (6) (6)", "a"}),
            (Names{"a", "a (6)", "a (6) (6)", "a (6) (6) (6)"}));
  // Cut to the same.
  const std::string cut(200, 'x');
  EXPECT_EQ(block_names({cut + "y", cut + "z"}), (Names{cut, cut + " (4)"}));
}

TEST_P(mesh_formats, have_names_of_regions_that_lode_reads_but_for_exodus) {
  if (is_exodus()) return;
  for (const std::vector<std::int64_t>& ids :
       {std::vector<std::int64_t>{3, 5, 8}, {-2, 0, 1}, {-70, 4, std::int64_t{1} << 40}}) {
    SimplexMesh mesh = strip(ids);
    mesh.region_names = {{ids[0], "rotor \xC3\xA9"}, {ids[2], "air"}};
    write(mesh, {.value_name = "wave"});
    auto cells = read_cell_mesh(path_, {});
    ASSERT_TRUE(cells) << cells.error().message;
    const auto made = to_tetrahedra(std::move(*cells), {});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->mesh.region_ids, ids);
    if (std::string(GetParam()) == ".vtk")
      EXPECT_TRUE(made->mesh.region_names.empty());
    else
      EXPECT_EQ(made->mesh.region_names, (std::vector<std::string>{"rotor \xC3\xA9", "", "air"}));
  }
}

TEST_P(mesh_formats, keep_regions_whose_numbers_cannot_be_tags) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  const SimplexMesh mesh = strip({-2, 0, std::int64_t{1} << 40});
  write(mesh, {.value_name = "wave"});
  const json read = seen();
  expect_same(read, mesh, "wave");
  if (!has_blocks()) return;
  for (const json& cell : read.at("cells"))
    EXPECT_EQ(cell[3], "region " + std::to_string(cell[2].get<std::int64_t>()));
  if (is_exodus()) EXPECT_EQ(read.at("ids"), json({1, 2, 3}));
}

TEST_P(mesh_formats, are_read_by_lode_itself_but_for_exodus) {
  if (is_exodus()) return;
  for (const std::vector<std::int64_t>& regions :
       {std::vector<std::int64_t>{}, {3, 5}, {-2, 0, 1}, {0, 4}}) {
    const SimplexMesh mesh = strip(regions);
    write(mesh, {.value_name = "wave"});
    auto cells = read_cell_mesh(path_, {});
    ASSERT_TRUE(cells) << cells.error().message;
    EXPECT_EQ(cells->points, mesh.positions);
    ASSERT_EQ(cells->cell_fields.size(), regions.empty() ? 1U : 2U);
    std::vector<double> errors;
    for (const MeshField& field : cells->cell_fields)
      if (field.name == "error") errors = field.values;
    std::vector<double> expected(mesh.errors.begin(), mesh.errors.end());
    std::sort(errors.begin(), errors.end());
    EXPECT_EQ(errors, expected);
    const auto made = to_tetrahedra(std::move(*cells), {});
    ASSERT_TRUE(made) << made.error().message;
    ASSERT_EQ(made->mesh.fields.size(), 1U);
    EXPECT_EQ(made->mesh.fields[0].name, "wave");
    EXPECT_EQ(made->mesh.fields[0].values, mesh.values);
    SimplexMesh read;
    read.tetrahedra = made->mesh.tetrahedra;
    read.errors.assign(mesh.errors.size(), 0);
    SimplexMesh plain = mesh;
    plain.errors = read.errors;
    if (!regions.empty())
      for (const std::uint32_t region : made->mesh.regions)
        read.regions.push_back(made->mesh.region_ids.at(region));
    EXPECT_EQ(rows_of(read), rows_of(plain));
  }
}

TEST_P(mesh_formats, hold_triangles_and_narrow_values_and_nothing) {
  ASSERT_TRUE(test::has_vtk()) << test::kVtkMissing;
  SimplexMesh mesh;
  mesh.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}};
  mesh.values = {1, 2, 3, 4.5};
  mesh.has_narrow_values = true;
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.errors = {0, 1};
  write(mesh, {.value_name = "isovalue"});
  expect_same(seen(), mesh, "value");
  write({}, {.value_name = "a <\"b\"> & c"});
  const json empty = seen();
  EXPECT_EQ(empty.at("points").size(), 0U);
  EXPECT_EQ(empty.at("cells").size(), 0U);
}

TEST_P(mesh_formats, leave_nothing_when_cancelled_or_without_a_place) {
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(write_mesh(path_, strip({}), {}, cancelled));
  EXPECT_FALSE(std::filesystem::exists(path_));
  Progress progress;
  const auto status =
      write_mesh(std::string("/nonexistent/x") + GetParam(), strip({}), {}, progress);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("/nonexistent/x"), std::string::npos);
}

TEST_P(mesh_formats, have_the_same_bytes_each_time) {
  const auto bytes = [&] {
    write(strip({2, 1}), {.comment = std::string(300, 'x'), .value_name = std::string(300, 'y')});
    std::ifstream file(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string first = bytes();
  EXPECT_GT(first.size(), 1000U);
  EXPECT_EQ(first, bytes());
}

INSTANTIATE_TEST_SUITE_P(all, mesh_formats, testing::Values(".vtk", ".msh", ".e", ".ex2", ".exo"),
                         [](const auto& format) { return std::string(format.param).substr(1); });

TEST(mesh_paths, are_known_by_their_extension) {
  for (const char* const path : {"a.vtu", "a.VTK", "b/a.msh", "a.e", "a.Exo", "a.ex2"})
    EXPECT_TRUE(check_mesh_path(path)) << path;
  for (const char* const path : {".vtu", "a.vtp", "a.mesh", "e", "a.e/b", ""}) {
    const auto status = check_mesh_path(path);
    ASSERT_FALSE(status) << path;
    EXPECT_NE(status.error().message.find(".vtu, .vtk, .msh"), std::string::npos);
  }
}

TEST(netcdf_output, refuses_what_its_format_cannot_hold) {
  NetcdfContent content;
  content.dimensions = {{"n", 1U << 29U}};
  content.variables.push_back({.name = "x", .dimensions = {0}, .n_rows = 1});
  EXPECT_EQ(netcdf_data_bytes(content), std::uint64_t{1} << 32U);
  Progress progress;
  const std::string path = file_path("huge.e");
  auto file = SurfaceOutput::create(path, 0, progress, {2});
  ASSERT_TRUE(file);
  const auto status = write_netcdf(path, content, *file);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("4 GiB of x"), std::string::npos) << status.error().message;
}

}  // namespace
}  // namespace lode::io
