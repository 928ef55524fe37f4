// Midpoint placement, and orders of collapses, through the program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <tuple>

#include "lode/api/files.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_isosurface.h"
#include "tests/cli/program.h"
#include "tests/cli/tetra_placement.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::test {
namespace {

double volume(const TetraMesh& mesh, std::size_t cell) {
  const auto& [a, b, c, d] = mesh.tetrahedra[cell];
  const auto& p = mesh.positions;
  return dot(cross(p[b] - p[a], p[c] - p[a]), p[d] - p[a]) / 6;
}

/// Boxes of the cells, with room for roundings.
std::vector<std::array<Vec3d, 2>> boxes_of(const TetraMesh& mesh) {
  std::vector<std::array<Vec3d, 2>> boxes;
  for (const auto& t : mesh.tetrahedra) {
    auto& [lower, upper] = boxes.emplace_back();
    lower = upper = mesh.positions[t[0]];
    for (const std::uint32_t v : t)
      for (std::size_t i = 0; i < 3; ++i) {
        lower[i] = std::min(lower[i], mesh.positions[v][i] - 1e-6);
        upper[i] = std::max(upper[i], mesh.positions[v][i] + 1e-6);
      }
  }
  return boxes;
}

/// The largest |F - F'| at the points of the noise, each found by trying all cells.
double largest_error(const SimplexMesh& reference, const TetraMesh& mesh) {
  const auto boxes = boxes_of(mesh);
  double largest = 0;
  for (std::size_t v = 0; v < reference.positions.size(); ++v) {
    double best = -1;
    double value = 0;
    const Vec3d& p = reference.positions[v];
    for (std::size_t cell = 0; cell < boxes.size(); ++cell) {
      const auto& [lower, upper] = boxes[cell];
      if (p[0] < lower[0] || p[0] > upper[0] || p[1] < lower[1] || p[1] > upper[1] ||
          p[2] < lower[2] || p[2] > upper[2])
        continue;
      const auto& t = mesh.tetrahedra[cell];
      std::array<Vec3d, 4> to;
      for (std::size_t i = 0; i < 4; ++i) to[i] = mesh.positions[t[i]] - p;
      const std::array<double, 4> weights{
          dot(to[1], cross(to[2], to[3])), -dot(to[0], cross(to[2], to[3])),
          dot(to[0], cross(to[1], to[3])), -dot(to[0], cross(to[1], to[2]))};
      const double all = weights[0] + weights[1] + weights[2] + weights[3];
      const double least =
          std::min({weights[0] / all, weights[1] / all, weights[2] / all, weights[3] / all});
      if (least <= best) continue;
      best = least;
      value = 0;
      for (std::size_t i = 0; i < 4; ++i) value += weights[i] / all * mesh.fields[0].values[t[i]];
    }
    EXPECT_GT(best, -1e-6);
    largest = std::max(largest, std::abs(value - reference.values[v]));
  }
  return largest;
}

TEST_F(cli_tetra_placement, at_no_tolerance_is_the_mesh_that_was_read_bit_for_bit) {
  const nlohmann::json json = done(midpoint({input_, output_, "--mesh", "--max-error", "0"}));
  EXPECT_EQ(json.at("placement"), "midpoint");
  EXPECT_EQ(json.at("error_kind"), "at samples");
  EXPECT_EQ(json.at("achieved_error"), 0);
  EXPECT_EQ(json.at("cells"), json.at("reference_cells"));
  EXPECT_LT(json.at("base_cells"), json.at("reference_cells").get<int>() / 5);
  EXPECT_EQ(sorted_cells(read(output_)), sorted_cells(read(input_)));
}

TEST_F(cli_tetra_placement, keeps_tolerances_at_all_samples_and_the_domain) {
  const SimplexMesh reference = noise();
  const auto [low, high] = std::ranges::minmax(reference.values);
  std::uint64_t n_last = 0;
  for (const double share : {0.3, 0.1, 0.03}) {
    const double tolerance = share * (high - low);
    const nlohmann::json json =
        done(midpoint({input_, output_, "--mesh", "--max-error", std::to_string(tolerance)}));
    EXPECT_LE(json.at("largest_error"), tolerance);
    const TetraMesh mesh = read(output_);
    EXPECT_EQ(mesh.tetrahedra.size(), json.at("cells"));
    EXPECT_GT(mesh.tetrahedra.size(), n_last);
    n_last = mesh.tetrahedra.size();
    // Positions and values are read as they were written; the search's own rounding is far less.
    EXPECT_LE(largest_error(reference, mesh), json.at("largest_error").get<double>() + 1e-9);
    double sum = 0;
    for (std::size_t cell = 0; cell < mesh.tetrahedra.size(); ++cell) {
      EXPECT_GT(volume(mesh, cell), 0);
      sum += volume(mesh, cell);
    }
    EXPECT_NEAR(sum, 1, 1e-6);
  }
  EXPECT_LT(n_last, reference.tetrahedra.size());
}

TEST_F(cli_tetra_placement, has_new_vertices_that_half_edges_have_not) {
  const auto n_new = [&](const std::string& placement) {
    EXPECT_EQ(
        done({"extract", input_, output_, "--mesh", "--max-error", "0.3", "--placement", placement})
            .at("placement"),
        placement);
    int n = 0;
    for (const Vec3d& p : read(output_).positions)
      for (std::size_t i = 0; i < 3; ++i) {
        const double step = p[i] * (kPoints - 1);
        if (std::abs(step - std::round(step)) > 1e-3) {
          ++n;
          break;
        }
      }
    return n;
  };
  EXPECT_EQ(n_new("half-edge"), 0);
  EXPECT_GT(n_new("midpoint"), 10);
}

TEST_F(cli_tetra_placement, makes_surfaces_sections_and_boundaries_of_the_reference) {
  const SimplexMesh all = noise();
  const std::string ply = scratch_ / "out.ply";
  const auto surface_of = [&](Words options) {
    options.insert(options.begin(), {input_, ply});
    options.insert(options.end(), {"--max-error", "0"});
    const nlohmann::json json = done(midpoint(options));
    auto surface = read_surface(ply);
    EXPECT_TRUE(surface);
    EXPECT_EQ(json.at("triangles"), surface->triangles.size());
    return std::move(*surface);
  };
  const auto [low, high] = std::ranges::minmax(all.values);
  const double isovalue = 0.5 * (low + high) + 0.01;
  Surface expected;
  add_isosurface(all, isovalue, {.margin = rounding_margin(all.positions, {})}, expected);
  const Surface found = surface_of({"--isovalue", fmt::format("{}", isovalue)});
  EXPECT_GT(expected.triangles.size(), 100U);
  EXPECT_EQ(oracles::sorted_triangles(found), oracles::sorted_triangles(expected));
  EXPECT_EQ(found.normals.size(), found.positions.size());
  EXPECT_EQ(oracles::sorted_triangles(surface_of({"--boundary"})),
            oracles::sorted_triangles(mesh_boundary(all, {}, {})));
  const Surface section = surface_of({"--section", "0,0,0.4:0,0,1"});
  double area = 0;
  for (const auto& [a, b, c] : section.triangles) {
    const auto at = [&](std::uint32_t v) {
      const Vec3f& p = section.positions[v];
      return Vec3d{
          {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}};
    };
    area += 0.5 * length(cross(at(b) - at(a), at(c) - at(a)));
  }
  EXPECT_NEAR(area, 1, 1e-5);  // Float32 holds positions within 6e-8 of a unit square.
}

TEST_F(cli_tetra_placement, takes_foci_budgets_thresholds_and_deadlines) {
  const nlohmann::json all = done(midpoint({input_, output_, "--mesh", "--max-error", "0"}));
  const nlohmann::json box =
      done(midpoint({input_, output_, "--mesh", "--max-error", "0", "--box", "0,0.3,0,0.3,0,0.3"}));
  EXPECT_EQ(box.at("achieved_error"), 0);
  EXPECT_LT(box.at("cells"), all.at("cells"));
  const nlohmann::json budget =
      done(midpoint({input_, output_, "--mesh", "--max-cells", std::to_string(kBudget)}));
  EXPECT_LE(budget.at("cells"), kBudget);
  EXPECT_TRUE(budget.at("budget_met"));
  const nlohmann::json part =
      done(midpoint({input_, output_, "--mesh", "--max-error", "0", "--threshold", "-0.1:0.1"}));
  EXPECT_GT(part.at("left_out"), 0);
  const TetraMesh mesh = read(output_);
  ASSERT_FALSE(mesh.tetrahedra.empty());
  for (const double value : mesh.fields[0].values) EXPECT_LE(std::abs(value), 0.1);
  const nlohmann::json late = done(midpoint({input_, output_, "--mesh", "--deadline-ms", "0"}));
  EXPECT_EQ(late.at("is_settled"), false);
  EXPECT_EQ(late.at("cells"), late.at("base_cells"));
}

TEST_F(cli_tetra_placement, draws_pictures_of_midpoints) {
  const auto picture = [&](const char* placement) {
    const std::string path = scratch_ / (std::string(placement) + ".png");
    const Finished run = run_lode({"render", input_, path, "--opacity", "smoke", "--max-error",
                                   "0.3", "--size", "64x64", "--placement", placement});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string midpoints = picture("midpoint");
  EXPECT_GT(midpoints.size(), 500U);
  EXPECT_NE(midpoints, picture("half-edge"));
}

TEST_F(cli_tetra_placement, keeps_regions) {
  SimplexMesh mesh = noise();
  for (const auto& cell : mesh.tetrahedra) {
    double x = 0;
    for (const std::uint32_t v : cell) x += mesh.positions[v][0] / 4;
    mesh.regions.push_back(x < 0.5 ? 40 : -2);
  }
  Progress progress;
  ASSERT_TRUE(write_vtu(input_, mesh, {.value_name = "noise"}, progress));
  const auto volumes = [&](const Words& options) {
    Words words{input_, output_, "--mesh", "--max-error", "0.3"};
    words.insert(words.end(), options.begin(), options.end());
    EXPECT_GT(done(midpoint(words)).at("cells"), 0);
    const TetraMesh made = read(output_);
    std::map<std::int64_t, double> sums;
    for (std::size_t i = 0; i < made.tetrahedra.size(); ++i)
      sums[made.region_ids.at(made.regions.empty() ? 0 : made.regions[i])] += volume(made, i);
    return sums;
  };
  const auto both = volumes({});
  ASSERT_EQ(both.size(), 2U);
  EXPECT_NEAR(both.at(40), 0.5, 1e-6);
  EXPECT_NEAR(both.at(-2), 0.5, 1e-6);
  const auto one = volumes({"--region", "40"});
  ASSERT_EQ(one.size(), 1U);
  EXPECT_NEAR(one.begin()->second, 0.5, 1e-6);
}

TEST_F(cli_tetra_placement, is_the_same_for_any_number_of_threads) {
  const auto bytes = [&](const char* threads) {
    static_cast<void>(
        done(midpoint({input_, output_, "--mesh", "--max-error", "0.1", "--threads", threads})));
    std::ifstream file(output_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string one = bytes("1");
  EXPECT_EQ(one, bytes("3"));
  EXPECT_GT(one.size(), 1000U);
}

TEST_F(cli_tetra_placement, takes_orders_whose_errors_are_as_true) {
  const SimplexMesh reference = noise();
  const std::map<std::string, Words> orders{
      {"error", {}}, {"space", {"--order", "space"}}, {"quadric", {"--fast"}}};
  for (const char* placement : {"half-edge", "midpoint"}) {
    std::map<std::string, std::vector<CellKey>> cells;
    for (const auto& [order, options] : orders) {
      Words words{"extract",     input_, output_,       "--mesh",
                  "--max-error", "0.3",  "--placement", placement};
      words.insert(words.end(), options.begin(), options.end());
      const nlohmann::json json = done(words);
      EXPECT_EQ(json.at("order"), order);
      EXPECT_EQ(json.at("placement"), placement);
      EXPECT_LE(json.at("largest_error"), 0.3);
      EXPECT_LE(largest_error(reference, read(output_)),
                json.at("largest_error").get<double>() + 1e-9);
      cells[order] = sorted_cells(read(output_));
    }
    EXPECT_NE(cells["error"], cells["space"]);
    EXPECT_NE(cells["error"], cells["quadric"]);
    static_cast<void>(done({"extract", input_, output_, "--mesh", "--max-error", "0.3", "--order",
                            "quadric", "--placement", placement}));
    EXPECT_EQ(sorted_cells(read(output_)), cells["quadric"]);
  }
}

TEST_F(cli_tetra_placement, refuses_orders_that_cannot_be_meant) {
  const auto refused = [&](const Words& options, const std::string& message) {
    Words words{"extract", input_, output_, "--mesh"};
    words.insert(words.end(), options.begin(), options.end());
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  };
  refused({"--order", "size"}, "--order: expected error, space or quadric, got 'size'");
  refused({"--order", "space", "--fast"}, "--order: expected 'quadric' with --fast, got 'space'");
  refused({"--placement", "midpoint", "--order", "space", "--fast"},
          "--order: expected 'quadric' with --fast, got 'space'");
}

TEST_F(cli_tetra_placement, says_what_it_does_not_do) {
  const auto refused = [&](const Words& words, const std::string& message) {
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  };
  const std::string model = scratch_ / "out.lode";
  refused({"build", input_, model, "--placement", "midpoint", "--everywhere"},
          "--placement midpoint: expected no --everywhere with it, which follows half edges alone");
  EXPECT_FALSE(std::ifstream(model).is_open());
  refused({"build", input_, model, "--placement", "centre"},
          "expected half-edge or midpoint, got 'centre'");
  refused({"extract", input_, output_, "--mesh", "--placement", "centre"},
          "expected half-edge or midpoint, got 'centre'");
  refused(midpoint({scratch_ / "volume.nrrd", output_, "--mesh"}),
          "--placement: expected a mesh of cells, got a volume");
  EXPECT_EQ(run_lode({"build", input_, model, "--placement", "half-edge"}).exit_code, 0);
  refused(midpoint({model, output_, "--mesh"}),
          "expected no options of reading but --field, --with and --time, got --placement");
}

}  // namespace
}  // namespace lode::test
