// Meshes of cells through the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "lode/api/files.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/mappers/section.h"
#include "lode/mappers/surface_topology.h"
#include "tests/cli/tetra_fixture.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::test {
namespace {

TEST_F(cli_tetra, at_no_tolerance_is_the_mesh_that_was_read) {
  const nlohmann::json json = report({"--max-error", "0"});
  EXPECT_EQ(json.at("model"), "tetra_mt");
  EXPECT_EQ(json.at("field"), "wave");
  EXPECT_EQ(json.at("cells"), 12 * 12 * 12 * 6);
  EXPECT_EQ(json.at("vertices"), 13 * 13 * 13);
  EXPECT_EQ(json.at("achieved_error"), 0);
  EXPECT_LT(json.at("base_cells"), 1000);
  EXPECT_EQ(json.at("reading").at("zero_volume"), 0);
  auto cells = read_cell_mesh(output_, {});
  ASSERT_TRUE(cells);
  const auto mesh = to_tetrahedra(std::move(*cells), {});
  ASSERT_TRUE(mesh);
  const SimplexMesh all = waves(13);
  ASSERT_EQ(mesh->mesh.positions.size(), all.positions.size());
  for (std::size_t v = 0; v < all.positions.size(); ++v) {
    const auto& p = mesh->mesh.positions[v];
    const auto at = static_cast<std::size_t>((p[2] * 13 + p[1]) * 13 + p[0]);
    EXPECT_EQ(mesh->mesh.fields[0].values[v], all.values[at]);
  }
}

TEST_F(cli_tetra, keeps_tolerances_foci_and_budgets) {
  const nlohmann::json coarse = report({"--max-error", "1"});
  EXPECT_LE(coarse.at("largest_error"), 1);
  EXPECT_LT(coarse.at("cells"), 12 * 12 * 12 * 6 / 4);
  const nlohmann::json focused = report({"--max-error", "0.1", "--box", "0,3,0,3,0,3"});
  const nlohmann::json fine = report({"--max-error", "0.1"});
  EXPECT_LE(focused.at("achieved_error"), 0.1);
  EXPECT_GT(focused.at("largest_error"), 0.1);
  EXPECT_LT(focused.at("cells"), fine.at("cells"));
  const nlohmann::json isovalue = report({"--max-error", "0", "--isovalue", "8"});
  EXPECT_LT(isovalue.at("cells"), 12 * 12 * 12 * 6);
  const nlohmann::json both =
      report({"--max-error", "0", "--isovalue", "8", "--max-error-outside", "1"});
  EXPECT_LE(both.at("largest_error"), 1);
  int n_last = 0;
  double error_last = 100;
  for (const int budget : {1200, 2000, 3000, 6000}) {
    const nlohmann::json within = report({"--max-cells", std::to_string(budget)});
    EXPECT_LE(within.at("cells"), budget);
    EXPECT_GE(within.at("cells"), std::max(n_last, budget / 2));
    EXPECT_LE(within.at("achieved_error"), error_last);
    n_last = within.at("cells");
    error_last = within.at("achieved_error");
  }
  EXPECT_EQ(report({"--max-cells", "1"}).at("budget_met"), false);
}

TEST_F(cli_tetra, keeps_regions_apart_and_writes_them) {
  SimplexMesh mesh = waves(13);
  // A material in a corner; the rest is another one.
  for (const auto& cell : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : cell) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(centre[0] < 6 && centre[1] < 4 && centre[2] < 8 ? 40 : -2);
  }
  Progress progress;
  ASSERT_TRUE(write_vtu(input_, mesh, {.value_name = "wave"}, progress));
  const std::string model = scratch_ / "wave.lode";
  const Finished build = run_lode({"build", input_, model, "--json"});
  ASSERT_EQ(build.exit_code, 0) << build.err;
  EXPECT_EQ(build.json().at("regions"), nlohmann::json({-2, 40}));
  const auto volumes = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"extract", model, output_, "--mesh"};
    words.insert(words.end(), options.begin(), options.end());
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    auto cells = read_cell_mesh(output_, {});
    EXPECT_TRUE(cells);
    const auto made =
        to_tetrahedra(std::move(*cells), {.fields = std::vector<std::string>{"wave"}});
    EXPECT_TRUE(made);
    std::map<std::int64_t, double> sums;
    for (std::size_t i = 0; i < made->mesh.tetrahedra.size(); ++i) {
      const auto& [a, b, c, d] = made->mesh.tetrahedra[i];
      const auto& p = made->mesh.positions;
      const std::size_t place = made->mesh.regions.empty() ? 0 : made->mesh.regions[i];
      sums[made->mesh.region_ids.at(place)] +=
          dot(cross(p[b] - p[a], p[c] - p[a]), p[d] - p[a]) / 6;
    }
    return sums;
  };
  for (const char* const tolerance : {"0", "0.4", "2", "1000"}) {
    const auto found = volumes({"--max-error", tolerance});
    ASSERT_EQ(found.size(), 2U);
    EXPECT_NEAR(found.at(40), 6 * 4 * 8, 1e-6);
    EXPECT_NEAR(found.at(-2), 12 * 12 * 12 - 6 * 4 * 8, 1e-6);
  }
  const auto one = volumes({"--max-error", "0.4", "--region", "40"});
  ASSERT_EQ(one.size(), 1U);
  EXPECT_NEAR(one.begin()->second, 6 * 4 * 8, 1e-6);
  // On surfaces as well.
  for (const Words& of : {Words{"--boundary"},
                          {"--isovalue", "3"},
                          {"--section", "6,6,6:1,2,3"},
                          {"--section", "6,6,6:1,2,3", "--isovalue", "3"}})
    for (const char* const name : {"out.vtp", "out.ply"}) {
      Words words{"extract", model, scratch_ / name, "--max-error", "0.4"};
      words.insert(words.end(), of.begin(), of.end());
      ASSERT_EQ(run_lode(words).exit_code, 0);
      const std::string bytes = read_bytes(scratch_ / name);
      EXPECT_NE(bytes.find(name == std::string("out.vtp") ? "Name=\"RegionId\""
                                                          : "property double region"),
                std::string::npos);
      EXPECT_TRUE(read_surface(scratch_ / name)) << name;
    }
  EXPECT_NE(run_lode({"info", model}).out.find("-2, 40"), std::string::npos);
  EXPECT_EQ(run_lode({"info", input_, "--json"}).json().at("regions"), nlohmann::json({-2, 40}));
  const Finished none = run_lode({"extract", model, output_, "--mesh", "--region", "5"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("expected one of -2, 40, got 5"), std::string::npos) << none.err;
}

TEST_F(cli_tetra, answers_out_of_files_as_out_of_memory) {
  const std::string model = scratch_ / "wave.lode";
  const Finished build = run_lode({"build", input_, model, "--json"});
  ASSERT_EQ(build.exit_code, 0) << build.err;
  EXPECT_EQ(build.json().at("cells"), 12 * 12 * 12 * 6);
  EXPECT_EQ(build.json().at("file_bytes"), std::filesystem::file_size(model));
  const Finished info = run_lode({"info", model, "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(info.json().at("field"), "wave");
  EXPECT_EQ(info.json().at("base_cells"), build.json().at("base_cells"));
  EXPECT_EQ(run_lode({"info", input_, "--json"}).json().at("tetrahedra"), 12 * 12 * 12 * 6);
  const auto bytes = [&](const std::string& from, std::vector<std::string> options) {
    options.insert(options.begin(), {"extract", from, output_});
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::ifstream file(output_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--mesh", "--max-error", "0.2"},
        {"--mesh", "--max-error", "0", "--box", "0,3,0,3,0,3"},
        {"--mesh", "--max-cells", "3000"}})
    EXPECT_EQ(bytes(input_, options), bytes(model, options));
  output_ = scratch_ / "out.ply";
  EXPECT_EQ(bytes(input_, {"--isovalue", "8", "--max-error", "0.1"}),
            bytes(model, {"--isovalue", "8", "--max-error", "0.1"}));
  EXPECT_EQ(run_lode({"extract", model, output_, "--field", "wave", "--mesh"}).exit_code, 2);
  std::filesystem::resize_file(model, std::filesystem::file_size(model) - 100);
  const Finished cut = run_lode({"info", model});
  EXPECT_EQ(cut.exit_code, 1);
  EXPECT_NE(cut.err.find("wave.lode"), std::string::npos) << cut.err;
}

/// Two tetrahedra at one face, whose corners each has for itself: of these one agrees in both
/// fields, one differs by 0.25 in f, one by 3 in the second component of v.
constexpr const char* kTorn = R"(# vtk DataFile Version 3.0
torn
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 8 double
0 0 0  1 0 0  0 1 0  0 0 1  0 0 0  1 0 0  0 1 0  0 0 -1
CELLS 2 10
4 0 1 2 3
4 4 6 5 7
CELL_TYPES 2
10 10
POINT_DATA 8
SCALARS f double 1
LOOKUP_TABLE default
0 1 2 3 0 1.25 2 5
VECTORS v double
1 2 2  1 2 2  1 2 2  1 2 2  1 2 2  1 2 2  1 5 2  1 2 2
)";

TEST_F(cli_tetra, has_files_that_say_how_they_were_read_and_built) {
  write_bytes(scratch_ / "torn.vtk", kTorn);
  const std::string model = scratch_ / "torn.lode";
  for (const Words& options : {Words{"--weld", "0", "--weld-values", "0.25", "--boundary-tolerance",
                                     "0.125", "--order", "space", "--keep-extrema"},
                               Words{"--placement", "midpoint", "--fast"}}) {
    Words words{"build", scratch_ / "torn.vtk", model, "--field", "f", "--json"};
    words.insert(words.end(), options.begin(), options.end());
    const Finished build = run_lode(words);
    ASSERT_EQ(build.exit_code, 0) << build.err;
    const Finished info = run_lode({"info", model, "--json"});
    ASSERT_EQ(info.exit_code, 0) << info.err;
    for (const char* key :
         {"order", "extrema", "boundary_tolerance", "volume_change", "base_vertices_kept"})
      EXPECT_EQ(info.json().at(key), build.json().at(key)) << key;
    const nlohmann::json kept = info.json().at("reading");
    EXPECT_EQ(kept.size(), 21U);
    for (const auto& [key, n] : kept.items())
      EXPECT_EQ(n, build.json().at("reading").at(key)) << key;
    EXPECT_EQ(info.json().at("notes").size(), 0U);
    // Attaching a field keeps it.
    const std::string more = scratch_ / "more.lode";
    words = {"attach-field", model, scratch_ / "torn.vtk", more, "--field", "v"};
    if (options.front() == "--weld")
      words.insert(words.end(), options.begin(), options.begin() + 4);
    const Finished attached = run_lode(words);
    ASSERT_EQ(attached.exit_code, 0) << attached.err;
    const nlohmann::json after = run_lode({"info", more, "--json"}).json();
    for (const char* key : {"order", "extrema", "boundary_tolerance", "reading"})
      EXPECT_EQ(after.at(key), info.json().at(key)) << key;
  }
  const Finished text = run_lode({"info", model});
  EXPECT_NE(text.out.find("points at another's place  3"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("order"), std::string::npos) << text.out;
}

TEST_F(cli_tetra, welds_points_where_all_fields_agree) {
  write_bytes(scratch_ / "torn.vtk", kTorn);
  const auto reading = [&](Words options) {
    options.insert(options.begin(), {"build", scratch_ / "torn.vtk", scratch_ / "torn.lode",
                                     "--field", "f", "--json"});
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json counts = run.json().at("reading");
    return Index3{
        {counts.at("welded_points"), counts.at("weld_refusals"), counts.at("coincident_points")}};
  };
  EXPECT_EQ(reading({}), (Index3{{0, 0, 3}}));
  EXPECT_EQ(reading({"--weld", "0"}), (Index3{{1, 2, 2}}));
  EXPECT_EQ(reading({"--weld", "0", "--weld-values", "0.25"}), (Index3{{2, 1, 1}}));
  EXPECT_EQ(reading({"--weld", "0.5", "--weld-values", "3"}), (Index3{{3, 0, 0}}));
  const Finished verified =
      run_lode({"verify", scratch_ / "torn.lode", "--against", scratch_ / "torn.vtk", "--weld",
                "0.5", "--weld-values", "3"});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_NE(
      run_lode({"verify", scratch_ / "torn.lode", "--against", scratch_ / "torn.vtk"}).exit_code,
      0);
  for (const auto& [options, message] : {std::pair{Words{"--weld", "-1"}, "--weld"},
                                         {Words{"--weld-values", "1"}, "--weld with it"},
                                         {Words{"--linearise", "no"}, "'corners'"},
                                         {Words{"--weld", "inf"}, "--weld"}}) {
    Words words{"info", scratch_ / "torn.vtk"};
    words.insert(words.end(), options.begin(), options.end());
    expect_refusal(run_lode(words), 2, {message});
  }
}

TEST_F(cli_tetra, takes_components_of_vectors_or_their_magnitude) {
  write_bytes(scratch_ / "torn.vtk", kTorn);
  const auto largest = [&](const char* component) {
    Words words{"build", scratch_ / "torn.vtk", scratch_ / "v.lode", "--field", "v", "--json"};
    if (*component != 0) words.insert(words.end(), {"--component", component});
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json().at("range")[1].get<double>();
  };
  EXPECT_EQ(largest("x"), 1);
  EXPECT_EQ(largest("y"), 5);
  EXPECT_EQ(largest("1"), 5);
  EXPECT_EQ(largest("z"), 2);
  EXPECT_NEAR(largest("magnitude"), std::sqrt(30), 1e-12);
  EXPECT_NEAR(largest(""), std::sqrt(30), 1e-12);
}

TEST_F(cli_tetra, writes_what_vtk_reads) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  const nlohmann::json json = report({"--max-error", "0.5"});
  const auto seen = nlohmann::json::parse(run_oracle(LODE_MESH_ORACLE, output_), nullptr, false);
  EXPECT_EQ(seen.at("cells"), json.at("cells"));
  EXPECT_EQ(seen.at("points"), json.at("vertices"));
  EXPECT_NEAR(seen.at("size").get<double>(), 12 * 12 * 12, 1e-6);
  EXPECT_GT(seen.at("smallest").get<double>(), 0);
  const std::string vtp = scratch_ / "out.vtp";
  for (const std::string kind : {"--boundary", "--section=1,2,3.3:0,0,1"}) {
    const nlohmann::json made =
        run_lode({"extract", input_, vtp, kind, "--max-error", "0.5", "--json"}).json();
    const auto read = nlohmann::json::parse(run_oracle(LODE_MESH_ORACLE, vtp), nullptr, false);
    EXPECT_EQ(read.at("cells"), made.at("triangles"));
    EXPECT_EQ(read.at("point_data").at("wave").at("tuples"), made.at("vertices"));
    EXPECT_EQ(read.at("cell_data").at("error").at("range")[1], made.at("achieved_error"));
    EXPECT_NEAR(read.at("size").get<double>(), (kind == "--boundary" ? 6 : 1) * 12 * 12, 1e-3);
  }
}

TEST_F(cli_tetra, is_the_same_for_any_number_of_threads) {
  const auto bytes = [&](const char* threads) {
    EXPECT_EQ(extract({"--max-error", "0.3", "--threads", threads}).exit_code, 0);
    std::ifstream file(output_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string one = bytes("1");
  EXPECT_EQ(one, bytes("3"));
  EXPECT_GT(one.size(), 1000U);
}

TEST_F(cli_tetra, has_meshes_that_are_fine_along_planes) {
  const auto cells = [&](std::vector<std::string> options) {
    options.insert(options.end(), {"--max-error", "0.01"});
    return report(std::move(options)).at("cells").get<std::uint64_t>();
  };
  const std::uint64_t everywhere = cells({});
  const std::uint64_t along = cells({"--section", "6.4,0,0:1,0,0"});
  EXPECT_LT(along, everywhere);
  auto mesh = read_cell_mesh(output_, {});
  ASSERT_TRUE(mesh) << mesh.error().message;
  const auto found = std::ranges::find(mesh->cell_fields, "error", &MeshField::name);
  ASSERT_NE(found, mesh->cell_fields.end());
  const std::vector<double> errors = found->values;
  const auto made = to_tetrahedra(std::move(*mesh), {});
  ASSERT_TRUE(made) << made.error().message;
  const TetraMesh& cut = made->mesh;
  ASSERT_EQ(errors.size(), cut.tetrahedra.size());
  double largest_beside = 0;
  for (std::size_t i = 0; i < cut.tetrahedra.size(); ++i) {
    double lower = 1e9;
    double upper = -1e9;
    for (const std::uint32_t v : cut.tetrahedra[i]) {
      lower = std::min(lower, cut.positions[v][0]);
      upper = std::max(upper, cut.positions[v][0]);
    }
    if (lower <= 6.4 && upper >= 6.4)
      EXPECT_LE(errors[i], 0.01);
    else
      largest_beside = std::max(largest_beside, errors[i]);
  }
  EXPECT_GT(largest_beside, 0.1);
  const std::uint64_t two = cells({"--section", "6.4,0,0:1,0,0", "--section", "0,1,0,3.3"});
  EXPECT_GT(two, along);
  EXPECT_LT(two, everywhere);
  const nlohmann::json bounded =
      report({"--section", "6.4,0,0:1,0,0", "--max-error", "0.01", "--max-error-outside", "0.05"});
  EXPECT_GE(bounded.at("cells"), along);
  EXPECT_LE(bounded.at("largest_error"), 0.05);
}

TEST_F(cli_tetra, says_what_it_does_not_do) {
  const auto refused = [&](const std::vector<std::string>& words, const char* message) {
    const Finished run = run_lode(words);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  };
  const std::string surface = scratch_ / "out.ply";
  refused({"extract", input_, surface}, "expected --isovalue or --mesh");
  refused({"extract", input_, surface, "--boundary", "--patch", "5"},
          "--patch: expected none, as the mesh has none, got 5");
  refused({"extract", input_, surface, "--section", "0,0,1:0,0,0"}, "expected a normal");
  refused({"extract", input_, output_, "--mesh", "--section", "0,0,1:0,0,0"}, "expected a normal");
  refused({"extract", input_, surface, "--boundary", "--section", "0,0,1:0,0,1"},
          "expected no --section");
  refused({"extract", input_, surface, "--boundary", "--mesh"}, "expected no --mesh");
  refused({"extract", input_, output_, "--boundary"}, "extension");
  refused({"extract", input_, surface, "--boundary", "--normals", "off"}, "--normals");
  refused({"extract", input_, surface, "--isovalue", "3", "--threshold", "1:2"},
          "expected --mesh or --boundary");
  refused({"extract", input_, output_, "--mesh", "--threshold", "2:1"}, "expected A <= B");
  refused({"extract", input_, output_, "--mesh", "--max-error-outside", "1"},
          "--max-error-outside: expected a focus");
  refused({"extract", input_, surface, "--isovalue", "3", "--style", "cubes"}, "--style");
  refused({"extract", input_, surface, "--isovalue", "3", "--simplify"}, "--simplify");
  refused({"extract", input_, scratch_ / "out.glb", "--isovalue", "3", "--isovalue", "3.00000001"},
          "expected isovalues that differ as float32");
  refused({"extract", input_, scratch_ / "out.glb", "--isovalue", "3", "--isovalue", "1e300"},
          "expected isovalues that float32 holds");
  write_bytes(scratch_ / "in-4.obj",
              R"({"eye": [0, -9, 0], "target": [0, 0, 0], "up": [0, 0, 1]})");
  refused({"extract", input_, scratch_ / "in.obj", "--isovalue", "3", "--isovalue", "4", "--view",
           scratch_ / "in-4.obj"},
          "expected an output that is not an input");
  refused({"extract", input_, output_, "--mesh", "--memory-limit", "1G"}, "--memory-limit");
  refused({"extract", input_, output_, "--mesh", "--nodata", "3"},
          "--nodata: expected a volume or terrain, got a mesh of cells");
  refused(
      {"extract", input_, output_, "--mesh", "--time", "3"},
      "no options of reading but --field, --with, --component, --weld, --weld-values, "
      "--linearise, --region-field, --only-region, --placement, --order and --fast, got --time");
  refused({"info", input_, "--dims", "2x2x2", "--type", "uint8"},
          "--dims: expected a volume, got a mesh of cells");
  refused({"extract", input_, output_, "--mesh", "--field", "other"}, "other");
  refused({"extract", input_, input_, "--mesh"}, "expected an output that is not an input");
  refused({"count", input_, "--isovalue", "3"}, "which this command does not take");
  const std::string model = scratch_ / "model.lode";
  ASSERT_EQ(run_lode({"build", input_, model}).exit_code, 0);
  refused({"count", model, "--isovalue", "3"}, "got a mesh of cells");
  refused({"build", input_, scratch_ / "out.lode", "--memory-limit", "much"}, "--memory-limit");
  refused({"build", input_, scratch_ / "out.vtu"}, "expected an output that ends in .lode");
  refused({"build", input_, scratch_ / "out.lode", "--base-cells", "few"}, "--base-cells");
  const std::string broken = scratch_ / "broken.vtu";
  std::ofstream(broken) << "<VTKFile type=\"UnstructuredGrid\"";
  refused({"extract", broken, output_, "--mesh"}, "broken.vtu");
  const std::string empty = scratch_ / "empty.msh";
  std::ofstream(empty).close();
  refused({"extract", empty, output_, "--mesh"}, "empty.msh");
}

TEST_F(cli_tetra, collapses_edges_to_midpoints_where_that_is_asked_for) {
  const nlohmann::json all = report({"--max-error", "0", "--placement", "midpoint"});
  EXPECT_EQ(all.at("cells"), 12 * 12 * 12 * 6);
  EXPECT_EQ(all.at("vertices"), 13 * 13 * 13);
  EXPECT_EQ(all.at("achieved_error"), 0);
  const nlohmann::json half_edge = report({"--max-error", "1"});
  const nlohmann::json coarse = report({"--max-error", "1", "--placement", "midpoint"});
  EXPECT_LE(coarse.at("achieved_error"), 1);
  EXPECT_NE(coarse.at("cells"), half_edge.at("cells"));
  EXPECT_LT(coarse.at("cells"), 12 * 12 * 12 * 6 / 3);
  // Isosurfaces are those of the reference, and have normals, and boundaries are closed.
  const std::string ply = scratch_ / "out.ply";
  std::array<nlohmann::json, 2> made;
  for (const char* placement : {"half-edge", "midpoint"}) {
    const Finished run = run_lode({"extract", input_, ply, "--isovalue", "8", "--max-error", "0",
                                   "--placement", placement, "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    made[placement[0] == 'm' ? 1 : 0] = run.json();
  }
  EXPECT_EQ(made[0].at("triangles"), made[1].at("triangles"));
  EXPECT_EQ(run_lode({"extract", input_, ply, "--boundary", "--max-error", "1", "--placement",
                      "midpoint"})
                .exit_code,
            0);
  EXPECT_EQ(run_lode({"extract", input_, output_, "--mesh", "--placement", "centre"}).exit_code, 2);
  std::array<double, 2> probed{};
  for (const char* placement : {"half-edge", "midpoint"}) {
    const Finished probe = run_lode({"probe", input_, "--point", "1.3,1.2,1.1", "--max-error", "0",
                                     "--placement", placement, "--json"});
    ASSERT_EQ(probe.exit_code, 0) << probe.err;
    probed[placement[0] == 'm' ? 1 : 0] = probe.json().at("points")[0].at("value");
  }
  EXPECT_EQ(probed[0], probed[1]);
}

TEST_F(cli_tetra, builds_within_a_memory_limit_or_names_what_it_takes) {
  const std::string model = scratch_ / "limited.lode";
  const Finished small = run_lode({"build", input_, model, "--memory-limit", "16M"});
  EXPECT_EQ(small.exit_code, 1);
  EXPECT_NE(small.err.find("expected 18 MiB of memory to build a mesh of 10368 cells"),
            std::string::npos)
      << small.err;
  EXPECT_FALSE(std::filesystem::exists(model));
  EXPECT_EQ(run_lode({"build", input_, model, "--memory-limit", "20M"}).exit_code, 0);
}

TEST_F(cli_tetra, takes_views_and_deadlines) {
  const std::string camera = scratch_ / "camera.json";
  std::ofstream(camera) << R"({"eye": [-9, -9, -9], "target": [0, 0, 0], "up": [0, 0, 1],
                               "field_of_view_deg": 8})";
  const nlohmann::json seen = report({"--max-error", "0", "--view", camera});
  EXPECT_EQ(seen.at("achieved_error"), 0);
  EXPECT_LT(seen.at("cells"), 12 * 12 * 12 * 6);
  const nlohmann::json base = report({"--deadline-ms", "0"});
  EXPECT_EQ(base.at("is_settled"), false);
  EXPECT_EQ(base.at("cells"), base.at("base_cells"));
  // Of a mesh that is built for the question space errors are found, too.
  const nlohmann::json pixels = report({"--view", camera, "--max-error-px", "1"});
  EXPECT_LE(pixels.at("achieved_px"), 1);
  EXPECT_LE(pixels.at("cells"), seen.at("cells"));
}

}  // namespace
}  // namespace lode::test
