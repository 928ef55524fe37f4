// Surfaces of meshes of cells through the program: isosurfaces, sections, boundaries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/mappers/section.h"
#include "lode/mappers/surface_topology.h"
#include "tests/cli/tetra_fixture.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::test {
namespace {

TEST_F(cli_tetra, makes_isosurfaces_of_the_cut_and_of_the_reference_without_a_tolerance) {
  const std::string ply = scratch_ / "out.ply";
  const auto extract = [&](const char* isovalue, const char* tolerance, Surface& surface) {
    const Finished run = run_lode(
        {"extract", input_, ply, "--isovalue", isovalue, "--max-error", tolerance, "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    auto read = read_surface(ply);
    ASSERT_TRUE(read);
    surface = std::move(*read);
    EXPECT_EQ(run.json().at("triangles"), surface.triangles.size());
    EXPECT_EQ(run.json().at("vertices"), surface.positions.size());
    EXPECT_LE(run.json().at("achieved_error"), std::stod(tolerance));
  };
  for (const char* const isovalue : {"3.1", "8", "0"}) {
    Surface exact;
    extract(isovalue, "0", exact);
    const SimplexMesh all = waves(13);
    Surface reference;
    add_isosurface(all, std::stod(isovalue), {.margin = rounding_margin(all.positions, {})},
                   reference);
    EXPECT_EQ(oracles::sorted_triangles(exact), oracles::sorted_triangles(reference));
    Surface coarse;
    extract(isovalue, "0.5", coarse);
    EXPECT_LT(coarse.triangles.size(), exact.triangles.size());
    for (const Surface* surface : {&exact, &coarse}) {
      const TopologyReport topology = check_topology(*surface, {});
      EXPECT_EQ(topology.non_manifold_edges.count, 0U);
      EXPECT_EQ(topology.inconsistent_edges.count, 0U);
      EXPECT_EQ(topology.degenerate_simplices.count, 0U);
    }
    // Where F is the isovalue the wave is, but for what a step's square makes of it.
    for (const Vec3f& p : exact.positions)
      EXPECT_NEAR(10 * std::sin(0.5 * static_cast<double>(p[0])) *
                          std::cos(0.4 * static_cast<double>(p[1])) +
                      static_cast<double>(p[2]),
                  std::stod(isovalue), 1.2);
  }
}

/// The triangles of one isovalue.
Surface part_of(const Surface& all, double isovalue) {
  Surface part;
  part.positions = all.positions;
  for (const auto& triangle : all.triangles)
    if (all.isovalues[triangle[0]] == isovalue) part.triangles.push_back(triangle);
  return part;
}

TEST_F(cli_tetra, writes_isovalues_of_one_cut_to_a_file_each_where_formats_do_not_tell_them_apart) {
  const auto extract = [&](const std::string& path) {
    const Finished run = run_lode({"extract", input_, path, "--isovalue", "3.1", "--isovalue", "8",
                                   "--isovalue", "-2.5", "--max-error", "0.5", "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  };
  const std::string ply = scratch_ / "out.ply";
  const nlohmann::json whole = extract(ply);
  EXPECT_EQ(whole.at("outputs"), nlohmann::json({ply}));
  EXPECT_EQ(whole.at("isovalues"), nlohmann::json({3.1, 8.0, -2.5}));
  const Surface all = read_surface(ply).value();
  ASSERT_EQ(all.isovalues.size(), all.positions.size());
  for (const std::string extension : {".obj", ".stl"}) {
    const nlohmann::json apart = extract(scratch_ / ("out" + extension));
    EXPECT_EQ(apart.at("cut_cells"), whole.at("cut_cells"));
    EXPECT_EQ(apart.at("triangles"), whole.at("triangles"));
    EXPECT_EQ(apart.at("achieved_error"), whole.at("achieved_error"));
    EXPECT_FALSE(std::filesystem::exists(scratch_ / ("out" + extension)));
    nlohmann::json paths;
    for (const char* const isovalue : {"3.1", "8", "-2.5"}) {
      paths.push_back(scratch_ / ("out-" + std::string(isovalue) + extension));
      const Surface one = read_surface(paths.back()).value();
      EXPECT_GT(one.triangles.size(), 20U);
      EXPECT_EQ(oracles::sorted_triangles(one),
                oracles::sorted_triangles(part_of(all, std::stod(isovalue))))
          << paths.back();
      if (extension == ".obj") EXPECT_EQ(one.normals.size(), one.positions.size());
    }
    EXPECT_EQ(apart.at("outputs"), paths);
  }
  EXPECT_NE(read_bytes(scratch_ / "out-8.obj").find("isovalue 8, max_error 0.5"),
            std::string::npos);
}

TEST_F(cli_tetra, leaves_no_file_of_isovalues_where_one_cannot_be_written) {
  SimplexMesh far = waves(13);
  for (Vec3d& p : far.positions) p = p + Vec3d{{1e6, 1e6, 0}};
  const std::string input = scratch_ / "far.vtu";
  Progress progress;
  ASSERT_TRUE(write_vtu(input, far, {.value_name = "wave"}, progress));
  // The first is empty, the second has an origin, which STL has not got.
  const Finished run = run_lode({"extract", input, scratch_ / "out.stl", "--isovalue", "1000",
                                 "--isovalue", "3.1", "--max-error", "0.5"});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_NE(run.err.find("out-3.1.stl"), std::string::npos) << run.err;
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out-1000.stl"));
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out-3.1.stl"));
}

TEST_F(cli_tetra, gives_isosurfaces_normals_to_lower_values_unless_told_not_to) {
  const std::string ply = scratch_ / "out.ply";
  const auto extract = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"extract", input_, ply, "--isovalue", "3.1"});
    EXPECT_EQ(run_lode(options).exit_code, 0);
    return read_surface(ply).value();
  };
  EXPECT_TRUE(extract({"--normals", "off"}).normals.empty());
  for (const char* const tolerance : {"0", "0.5"}) {
    const Surface surface = extract({"--max-error", tolerance});
    ASSERT_EQ(surface.normals.size(), surface.positions.size());
    double sum = 0;
    for (std::size_t v = 0; v < surface.normals.size(); ++v) {
      const Vec3d p = widened(surface.positions[v]);
      const Vec3d slope{{5 * std::cos(0.5 * p[0]) * std::cos(0.4 * p[1]),
                         -4 * std::sin(0.5 * p[0]) * std::sin(0.4 * p[1]), 1}};
      const Vec3d normal = widened(surface.normals[v]);
      EXPECT_NEAR(length(normal), 1, 1e-6);
      sum += dot(normal, normalized(slope));
    }
    // Cells of size 1 under waves of length 12: some vertices of the border are far off.
    EXPECT_LT(sum / static_cast<double>(surface.normals.size()), -0.97);
  }
}

TEST_F(cli_tetra, cuts_sections_of_the_reference_and_of_cuts_that_are_fine_along_them) {
  const std::string vtp = scratch_ / "out.vtp";
  const auto extract = [&](std::vector<std::string> options, nlohmann::json& json) {
    options.insert(options.begin(), {"extract", input_, vtp, "--json"});
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    json = run.json();
    return read_surface(vtp).value();
  };
  struct Case {
    const char* plane;
    SectionPlane same;
  };
  nlohmann::json json;
  for (const auto& [plane, same] : {Case{"0,0,3.3:0.2,0.3,1", {{{0, 0, 3.3}}, {{0.2, 0.3, 1}}}},
                                    Case{"0,0,6:0,0,1", {{{0, 0, 6}}, {{0, 0, 1}}}},
                                    Case{"0,0,12:0,0,1", {{{0, 0, 12}}, {{0, 0, 1}}}}}) {
    const Surface exact = extract({"--section", plane, "--max-error", "0"}, json);
    EXPECT_EQ(json.at("triangles"), exact.triangles.size());
    EXPECT_EQ(json.at("achieved_error"), 0);
    const SimplexMesh all = waves(13);
    const Surface reference = cut_section(
        all, same, section_rounding({}, rounding_margin(all.positions, {}), same.normal));
    EXPECT_EQ(oracles::sorted_triangles(exact), oracles::sorted_triangles(reference));
    const TopologyReport topology = check_topology(exact, {});
    EXPECT_TRUE(topology.is_clean_manifold());
    const Surface coarse = extract({"--section", plane, "--max-error", "0.5"}, json);
    EXPECT_LE(json.at("achieved_error"), 0.5);
    EXPECT_LT(json.at("cut_cells"), 12 * 12 * 12 * 6 / 2);
    EXPECT_TRUE(check_topology(coarse, {}).is_clean_manifold());
  }
  // A plane by its equation.
  const Surface by_point = extract({"--section", "0,0,3.3:0.5,0,2", "--max-error", "0"}, json);
  EXPECT_EQ(
      oracles::sorted_triangles(extract({"--section", "0.5,0,2,6.6", "--max-error", "0"}, json))
          .size(),
      by_point.triangles.size());
  const std::vector<std::string> two{"--section", "0,0,3.3:0,0,1", "--section", "6.1,0,0:1,0,0"};
  EXPECT_EQ(check_topology(extract(two, json), {}).components.size(), 2U);
  const Surface lines =
      extract({"--section", "0,0,3.3:0,0,1", "--isovalue", "4", "--max-error", "0"}, json);
  EXPECT_GT(lines.lines.size(), 10U);
  EXPECT_EQ(json.at("lines"), lines.lines.size());
  EXPECT_TRUE(extract({"--section", "0,0,30:0,0,1"}, json).is_empty());
  EXPECT_EQ(json.at("warnings").size(), 1U);
}

TEST_F(cli_tetra, tells_bounds_and_ranges_before_a_model_is_built) {
  const nlohmann::json json = run_lode({"info", input_, "--json"}).json();
  EXPECT_EQ(json.at("bounds"), nlohmann::json({{0, 0, 0}, {12, 12, 12}}));
  const nlohmann::json& field = json.at("point fields").at(0);
  const SimplexMesh mesh = waves(13);
  const auto [low, high] = std::ranges::minmax(mesh.values);
  EXPECT_EQ(field.at("range"), nlohmann::json({low, high}));
  EXPECT_EQ(field.at("component_ranges"), nlohmann::json::array({{low, high}}));
  EXPECT_NE(run_lode({"info", input_}).out.find("wave, float64, "), std::string::npos);
}

TEST_F(cli_tetra, crops_surfaces_turns_them_and_drops_their_pieces) {
  const std::string ply = scratch_ / "out.ply";
  const auto surface_of = [&](Words options) {
    options.insert(options.begin(), {"extract", input_, ply, "--max-error", "0"});
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    auto read = read_surface(ply);
    EXPECT_TRUE(read);
    return std::move(*read);
  };
  const auto area = [](const Surface& surface) {
    double sum = 0;
    for (const auto& [a, b, c] : surface.triangles)
      sum += length(cross(surface.positions[b] - surface.positions[a],
                          surface.positions[c] - surface.positions[a])) /
             2;
    return sum;
  };
  for (const Words& what :
       {Words{"--isovalue", "3.1"}, {"--section", "6,6,6:1,2,0.5"}, {"--boundary"}}) {
    const auto with = [&](const Words& more) {
      Words words = what;
      words.insert(words.end(), more.begin(), more.end());
      return surface_of(words);
    };
    const Surface all = with({});
    const Surface left = with({"--clip", "-1,5.3,-1,20,-1,20"});
    const Surface right = with({"--clip", "5.3,20,-1,20,-1,20"});
    EXPECT_NEAR(area(left) + area(right), area(all), 1e-4 * area(all)) << what[0];
    for (const Vec3f& p : left.positions) EXPECT_LE(p[0], 5.30001F);
    const Surface turned = with({"--flip"});
    EXPECT_EQ(turned.triangles.at(0)[1], all.triangles.at(0)[2]);
    const auto n_most = std::to_string(all.triangles.size() + 1);
    EXPECT_TRUE(with({"--min-component", n_most}).is_empty());
  }
  expect_refusal(extract({"--clip", "0,1,0,1,0,1"}), 2, {"--clip", "--mesh"});
}

TEST_F(cli_tetra, writes_the_boundary_and_what_is_within_a_threshold) {
  const std::string ply = scratch_ / "out.ply";
  const auto boundary = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"extract", input_, ply, "--boundary", "--json"});
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  };
  EXPECT_EQ(boundary({"--max-error", "0"}).at("triangles"), 6 * 144 * 2);
  const nlohmann::json coarse = boundary({"--max-error", "1"});
  const Surface surface = read_surface(ply).value();
  EXPECT_LT(surface.triangles.size(), 1000U);
  EXPECT_LE(coarse.at("achieved_error"), 1);
  EXPECT_TRUE(check_topology(surface, {}).is_clean_manifold());
  EXPECT_TRUE(check_topology(surface, {}).is_closed());
  const nlohmann::json whole = report({"--max-error", "0", "--field-range", "2:9"});
  const nlohmann::json warm = report({"--max-error", "0", "--threshold", "2:9"});
  EXPECT_EQ(warm.at("left_out").get<int>() + warm.at("cells").get<int>(), whole.at("cells"));
  const auto cells = read_cell_mesh(output_, {});
  ASSERT_TRUE(cells);
  for (const double value : cells->point_fields.front().values) {
    EXPECT_GE(value, 2);
    EXPECT_LE(value, 9);
  }
  // What may be in the threshold is at full resolution.
  SimplexMesh reference = waves(13);
  std::vector<std::uint32_t> ids;
  keep_cells_within(reference, 2, 9, ids);
  EXPECT_EQ(warm.at("cells"), reference.n_cells());
  boundary({"--max-error", "0", "--threshold", "2:9"});
  EXPECT_EQ(oracles::sorted_triangles(read_surface(ply).value()),
            oracles::sorted_triangles(mesh_boundary(reference, {}, {})));
  const nlohmann::json none = boundary({"--threshold", "90:91"});
  EXPECT_EQ(none.at("triangles"), 0);
  EXPECT_EQ(none.at("warnings").size(), 1U);
}

}  // namespace
}  // namespace lode::test
