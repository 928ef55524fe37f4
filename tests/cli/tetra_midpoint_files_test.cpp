// Files of midpoints, and of any order of collapses, through the program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "tests/cli/tetra_placement.h"
#include "tests/io/vtk_oracle.h"

namespace lode::test {
namespace {

TEST_F(cli_tetra_placement, has_files_that_answer_as_memory_does) {
  const std::string model = scratch_ / "out.lode";
  const nlohmann::json built = done({"build", input_, model, "--placement", "midpoint"});
  EXPECT_EQ(built.at("placement"), "midpoint");
  EXPECT_EQ(built.at("fields").size(), 1U);
  // Each vertex of the base is kept by a rule; each node makes one vertex two.
  std::uint64_t n_kept = 0;
  for (const auto& [rule, n] : built.at("base_vertices_kept").items())
    n_kept += n.get<std::uint64_t>();
  EXPECT_EQ(n_kept,
            built.at("vertices").get<std::uint64_t>() - built.at("nodes").get<std::uint64_t>());
  const Finished said = run_lode({"build", input_, model, "--placement", "midpoint"});
  EXPECT_NE(said.out.find("base vertices kept"), std::string::npos) << said.out;
  const nlohmann::json info = done({"info", model});
  for (const char* key : {"placement", "cells", "vertices", "nodes", "base_cells", "range",
                          "base_error", "bounds", "boundary_deviation"})
    EXPECT_EQ(info.at(key), built.at(key)) << key;
  const auto bytes = [&](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string ply = scratch_ / "out.ply";
  const std::string png = scratch_ / "out.png";
  const std::vector<std::pair<std::string, Words>> questions{
      {output_, {"--mesh", "--max-error", "0"}},
      {output_, {"--mesh", "--max-error", "0.1"}},
      {output_, {"--mesh", "--max-cells", std::to_string(kBudget)}},
      {output_, {"--mesh", "--max-error", "0", "--box", "0,0.3,0,0.3,0,0.3"}},
      {output_, {"--mesh", "--max-error", "0", "--threshold", "-0.1:0.1"}},
      {ply, {"--isovalue", "0.1", "--max-error", "0.05"}},
      {ply, {"--section", "0,0,0.4:0,0,1", "--max-error", "0.05"}},
      {ply, {"--boundary", "--max-error", "0.1"}}};
  for (const auto& [path, options] : questions) {
    Words from_file{"extract", model, path};
    from_file.insert(from_file.end(), options.begin(), options.end());
    const nlohmann::json file = done(from_file);
    EXPECT_EQ(file.at("placement"), "midpoint");
    EXPECT_LE(file.at("bytes_read"), file.at("file_bytes"));
    const std::string expected = bytes(path);
    Words from_memory{input_, path};
    from_memory.insert(from_memory.end(), options.begin(), options.end());
    const nlohmann::json memory = done(midpoint(from_memory));
    EXPECT_EQ(file.at("achieved_error"), memory.at("achieved_error"));
    EXPECT_EQ(bytes(path), expected);
    EXPECT_GT(expected.size(), 500U);
  }
  std::vector<std::string> pictures;
  for (const Words& from : {Words{model}, Words{input_, "--placement", "midpoint"}}) {
    Words words{"render",      from[0], png,      "--opacity", "smoke",
                "--max-error", "0.3",   "--size", "64x64"};
    words.insert(words.end(), from.begin() + 1, from.end());
    EXPECT_EQ(run_lode(words).exit_code, 0);
    pictures.push_back(bytes(png));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_GT(pictures[0].size(), 500U);
}

TEST_F(cli_tetra_placement, verifies_and_probes_files_of_midpoints) {
  const std::string model = scratch_ / "out.lode";
  static_cast<void>(done({"build", input_, model, "--placement", "midpoint"}));
  const nlohmann::json verified = done({"verify", model, "--against", input_});
  EXPECT_GT(verified.at("checks").size(), 15U);
  for (const auto& check : verified.at("checks")) EXPECT_EQ(check.at("passed"), true) << check;
  const nlohmann::json exact =
      done({"probe", model, "--point", "0.31,0.42,0.53", "--max-error", "0"});
  const nlohmann::json coarse =
      done({"probe", model, "--point", "0.31,0.42,0.53", "--max-error", "0.3"});
  const double value = exact.at("points")[0].at("value");
  EXPECT_LE(coarse.at("points")[0].at("low").get<double>(), value);
  EXPECT_GE(coarse.at("points")[0].at("high").get<double>(), value);
  const nlohmann::json sums = done({"probe", model, "--integral", "--max-error", "0.3"});
  const nlohmann::json true_sums = done({"probe", model, "--integral", "--max-error", "0"});
  for (const char* name : {"volume", "integral", "minimum", "maximum"}) {
    const double number = true_sums.at(name).at("value");
    EXPECT_LE(sums.at(name).at("low").get<double>(), number + 1e-9);
    EXPECT_GE(sums.at(name).at("high").get<double>(), number - 1e-9);
  }
}

/// Halves that part along a plane, with values of their own there: points at one place.
SimplexMesh parted(SimplexMesh mesh) {
  const auto n_before = static_cast<std::uint32_t>(mesh.positions.size());
  std::vector<std::uint32_t> twins(n_before, n_before);
  for (std::uint32_t v = 0; v < n_before; ++v) {
    if (mesh.positions[v][1] != 0.5) continue;
    twins[v] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(mesh.positions[v]);
    mesh.values.push_back(mesh.values[v] - 0.5);
  }
  for (auto& t : mesh.tetrahedra)
    if (std::ranges::any_of(t, [&](std::uint32_t v) { return mesh.positions[v][1] < 0.5; }))
      for (std::uint32_t& v : t)
        if (twins[v] != n_before) v = twins[v];
  return mesh;
}

/// With a scalar and a vector.
void write_vtk(const std::string& path, const SimplexMesh& mesh) {
  std::ofstream out(path);
  out << "# vtk DataFile Version 3.0\nparted\nASCII\nDATASET UNSTRUCTURED_GRID\n";
  out << fmt::format("POINTS {} double\n", mesh.positions.size());
  for (const Vec3d& p : mesh.positions) out << fmt::format("{} {} {}\n", p[0], p[1], p[2]);
  const std::size_t n_cells = mesh.tetrahedra.size();
  out << fmt::format("CELLS {} {}\n", n_cells, 5 * n_cells);
  for (const auto& t : mesh.tetrahedra)
    out << fmt::format("4 {} {} {} {}\n", t[0], t[1], t[2], t[3]);
  out << fmt::format("CELL_TYPES {}\n", n_cells);
  for (std::size_t i = 0; i < n_cells; ++i) out << "10\n";
  out << fmt::format("POINT_DATA {}\nSCALARS noise double 1\nLOOKUP_TABLE default\n",
                     mesh.positions.size());
  for (const double value : mesh.values) out << fmt::format("{}\n", value);
  out << "SCALARS heat double 1\nLOOKUP_TABLE default\n";
  for (const double value : mesh.values) out << fmt::format("{}\n", 2 * std::cos(7 * value));
  out << "VECTORS flow double\n";
  for (const double value : mesh.values)
    out << fmt::format("{} {} {}\n", std::cos(5 * value), std::sin(9 * value), value);
}

class cli_midpoint_attachment : public cli_tetra_placement {
 protected:
  cli_midpoint_attachment() {
    write_vtk(mesh_, noise_);
    static_cast<void>(
        done({"build", mesh_, model_, "--placement", "midpoint", "--field", "noise"}));
  }
  [[nodiscard]] static std::string refusal(const Words& words) {
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 1);
    return run.err;
  }

  SimplexMesh noise_ = parted(noise());
  std::string mesh_ = scratch_ / "parted.vtk";
  std::string model_ = scratch_ / "model.lode";
  std::string some_ = scratch_ / "some.lode";
  std::string all_ = scratch_ / "all.lode";
};

/// A scalar at two times, a vector's magnitude, and one of its components.
TEST_F(cli_midpoint_attachment, takes_scalars_vectors_and_steps) {
  const nlohmann::json report =
      done({"attach-field", model_, mesh_, mesh_, some_, "--field", "heat", "--at", "0.5,2"});
  EXPECT_EQ(report.at("attached"), 2);
  EXPECT_EQ(report.at("fields")[2].at("time"), 2);
  EXPECT_EQ(report.at("file_bytes"), std::filesystem::file_size(some_));
  static_cast<void>(done({"attach-field", some_, mesh_, all_, "--field", "flow"}));
  static_cast<void>(
      done({"attach-field", all_, mesh_, all_, "--field", "flow", "--component", "y"}));
  const nlohmann::json info = done({"info", all_});
  ASSERT_EQ(info.at("fields").size(), 5U);
  EXPECT_EQ(info.at("fields")[1].at("time"), 0.5);
  EXPECT_FALSE(info.at("fields")[3].contains("time"));
  EXPECT_EQ(done({"verify", all_}).at("passed"), true);
  for (const Words& of : {Words{"noise"}, Words{"heat", "--time", "1"}, Words{"flow"}}) {
    Words words{"verify", all_, "--against", mesh_, "--field"};
    words.insert(words.end(), of.begin(), of.end());
    EXPECT_EQ(done(words).at("passed"), true);
  }
  // Half edges have the same values where all nodes are applied.
  const std::string half_edges = scratch_ / "half.lode";
  static_cast<void>(done({"build", mesh_, half_edges, "--field", "noise", "--with", "flow"}));
  const auto cells_of = [&](const std::string& file) {
    static_cast<void>(
        done({"extract", file, output_, "--mesh", "--field", "flow", "--max-error", "0"}));
    auto cells = read_cell_mesh(output_, {});
    EXPECT_TRUE(cells);
    auto made = to_tetrahedra(std::move(*cells), {.fields = std::vector<std::string>{"flow"}});
    EXPECT_TRUE(made);
    return sorted_cells(made->mesh);
  };
  EXPECT_EQ(cells_of(all_), cells_of(half_edges));
}

/// By the reader that was written from the document: points at one place, and a field that is not
/// the first.
TEST_F(cli_midpoint_attachment, makes_files_as_the_document_says) {
  Attribute heat{.name = "heat", .values = {}};
  for (const double value : noise_.values) heat.values.push_back(std::cos(7 * value));
  heat.errors.assign(noise_.tetrahedra.size(), 0);
  noise_.attributes = {heat};
  Progress progress;
  ASSERT_TRUE(write_vtu(input_, noise_, {.value_name = "noise"}, progress));
  static_cast<void>(done({"build", input_, model_, "--placement", "midpoint", "--field", "noise"}));
  static_cast<void>(done({"attach-field", model_, input_, some_, "--field", "heat"}));
  const std::string said = run_oracle(LODE_MIDPOINT_READER, "'" + some_ + "' '" + input_ + "'");
  const auto n_vertices = done({"info", some_}).at("vertices").get<std::size_t>();
  EXPECT_TRUE(said.starts_with(fmt::format("vertices {} ", n_vertices))) << said;
}

TEST_F(cli_midpoint_attachment, refuses_what_is_there_and_other_meshes) {
  EXPECT_NE(refusal({"attach-field", model_, mesh_, all_, "--field", "noise"})
                .find("expected a field that the model has not got"),
            std::string::npos);
  const std::string other = scratch_ / "other.vtk";
  noise_.positions[5][0] += 0.01;
  write_vtk(other, noise_);
  EXPECT_NE(refusal({"attach-field", model_, other, all_, "--field", "heat"})
                .find("other.vtk: expected the mesh that was built, with a vertex at"),
            std::string::npos);
  // Another seam: the same places, other cells at them.
  noise_.positions[5][0] -= 0.01;
  std::swap(noise_.positions[5], noise_.positions[6]);
  write_vtk(other, noise_);
  EXPECT_NE(refusal({"attach-field", model_, other, all_, "--field", "heat"}).find("expected"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(all_));
}

std::filesystem::path data_directory() {
  if (const char* directory = std::getenv("LODE_DATA")) return directory;
  return (std::filesystem::path(__FILE__).parent_path() / "../../../shared/data")
      .lexically_normal();
}

/// Curved boundaries, flat cells, coincident and unused points.
TEST_F(cli_tetra_placement, has_files_of_real_meshes_that_verify_within_24_bytes_a_vertex) {
  using Meshes = std::vector<std::pair<std::string, std::string>>;
  const auto meshes = oracles::trials(
      Meshes{{"disk_out_44832tets.vtu", "Temp"}, {"blunt_fin_187395tets.vtu", "Density"}},
      Meshes{{"disk_out_44832tets.vtu", "Temp"}});
  const std::string model = scratch_ / "real.lode";
  for (const auto& [name, field] : meshes) {
    const std::filesystem::path path = data_directory() / "tetra" / name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no tetra/" << name << "; set LODE_DATA";
    const nlohmann::json built =
        done({"build", path.string(), model, "--field", field, "--placement", "midpoint"});
    EXPECT_LE(built.at("file_bytes").get<double>(), 24 * built.at("vertices").get<double>());
    const nlohmann::json verified = done({"verify", model, "--against", path.string()});
    for (const auto& check : verified.at("checks")) EXPECT_EQ(check.at("passed"), true) << check;
  }
}

/// Of one mesh, in memory and from a file: values, errors, colours and pictures of another field.
TEST_F(cli_tetra_placement, takes_several_fields) {
  SimplexMesh mesh = noise();
  Attribute tilt{.name = "tilt", .values = {}};
  const auto height = [](double x, double y, double z) { return 3 * x - 2 * y + 0.5 * z + 7; };
  for (const Vec3d& p : mesh.positions) tilt.values.push_back(height(p[0], p[1], p[2]));
  Attribute waves{.name = "waves", .values = {}};
  for (const Vec3d& p : mesh.positions)
    waves.values.push_back(std::sin(9 * p[0]) * std::cos(7 * p[1]));
  for (Attribute* attribute : {&tilt, &waves}) {
    attribute->errors.assign(mesh.tetrahedra.size(), 0);
    mesh.attributes.push_back(*attribute);
  }
  Progress progress;
  ASSERT_TRUE(write_vtu(input_, mesh, {.value_name = "noise"}, progress));
  const std::string model = scratch_ / "out.lode";
  const Words fields{"--field", "noise", "--with", "waves", "--with", "tilt"};
  Words build{"build", input_, model, "--placement", "midpoint"};
  build.insert(build.end(), fields.begin(), fields.end());
  EXPECT_EQ(done(build).at("fields").size(), 3U);
  const std::string vtp = scratch_ / "out.vtp";
  const std::vector<std::pair<std::string, Words>> questions{
      {output_, {"--mesh", "--max-error", "0.1"}},
      {vtp, {"--isovalue", "0.1", "--max-error", "0.05"}},
      {vtp, {"--boundary", "--max-error", "0.1"}}};
  const auto bytes = [&](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  for (const auto& [path, options] : questions) {
    Words words{"extract", model, path};
    words.insert(words.end(), fields.begin(), fields.end());
    words.insert(words.end(), options.begin(), options.end());
    static_cast<void>(done(words));
    const std::string from_file = bytes(path);
    EXPECT_NE(from_file.find("\"tilt\""), std::string::npos);
    words[1] = input_;
    words.insert(words.end(), {"--placement", "midpoint"});
    static_cast<void>(done(words));
    EXPECT_EQ(bytes(path), from_file);
  }
  // Each by its own tolerance, and at none bit for bit.
  for (const char* field : {"noise", "waves", "tilt"}) {
    const nlohmann::json coarse =
        done({"extract", model, output_, "--mesh", "--field", field, "--max-error", "0.2"});
    EXPECT_LE(coarse.at("largest_error"), 0.2);
    static_cast<void>(done({"extract", model, output_, "--mesh", "--field", field, "--with",
                            field == std::string("tilt") ? "waves" : "tilt", "--max-error", "0"}));
    const auto values_of = [&](const std::string& path) {
      auto cells = read_cell_mesh(path, {});
      EXPECT_TRUE(cells);
      auto made = to_tetrahedra(std::move(*cells), {.fields = std::vector<std::string>{field}});
      EXPECT_TRUE(made);
      return sorted_cells(made->mesh);
    };
    EXPECT_EQ(values_of(output_), values_of(input_));
    const nlohmann::json probed =
        done({"probe", model, "--point", "0.31,0.42,0.53", "--field", field, "--max-error", "0"});
    if (field == std::string("tilt"))
      EXPECT_NEAR(probed.at("points")[0].at("value").get<double>(), height(0.31, 0.42, 0.53), 1e-6);
  }
  const nlohmann::json verified = done({"verify", model, "--against", input_});
  int n_waves = 0;
  for (const auto& check : verified.at("checks")) {
    EXPECT_EQ(check.at("passed"), true) << check;
    n_waves += check.at("name").get<std::string>().ends_with(": waves") ? 1 : 0;
  }
  EXPECT_GT(n_waves, 5);
  EXPECT_EQ(run_lode({"render", model, scratch_ / "out.png", "--opacity", "smoke", "--field",
                      "waves", "--max-error", "0.3", "--size", "64x64"})
                .exit_code,
            0);
}

/// Of a ball, within a share of its size.
TEST_F(cli_tetra_placement, lets_boundaries_move_by_as_much_as_is_asked_for) {
  SimplexMesh mesh = noise();
  for (Vec3d& p : mesh.positions) {
    p = (p - Vec3d{{0.5, 0.5, 0.5}}) * 2;
    const double largest = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    if (largest > 0) p = p * (largest / length(p));
  }
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    const auto& p = mesh.positions;
    return dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[3]] - p[t[0]]) < 1e-8;
  });
  mesh.errors.resize(mesh.tetrahedra.size());
  Progress progress;
  ASSERT_TRUE(write_vtu(input_, mesh, {.value_name = "noise"}, progress));
  const std::string model = scratch_ / "out.lode";
  int n_last = static_cast<int>(mesh.tetrahedra.size());
  for (const char* tolerance : {"0", "0.05", "0.2"}) {
    const nlohmann::json built = done({"build", input_, model, "--placement", "midpoint",
                                       "--base-cells", "0", "--boundary-tolerance", tolerance});
    EXPECT_LE(built.at("boundary_deviation").get<double>(), std::stod(tolerance) + 1e-5);
    EXPECT_LT(built.at("base_cells"), n_last);
    n_last = built.at("base_cells");
    EXPECT_EQ(done({"info", model}).at("boundary_tolerance"), std::stod(tolerance));
    EXPECT_EQ(run_lode({"info", model}).out.find("boundary tolerance") != std::string::npos,
              std::stod(tolerance) > 0);
    const nlohmann::json verified = done({"verify", model, "--against", input_});
    for (const auto& check : verified.at("checks")) EXPECT_EQ(check.at("passed"), true) << check;
  }
}

TEST_F(cli_tetra_placement, builds_files_in_any_order_that_verify) {
  const std::string model = scratch_ / "out.lode";
  for (const auto& [placement, order] :
       {std::pair("half-edge", "space"), {"half-edge", "quadric"}, {"midpoint", "quadric"}}) {
    EXPECT_EQ(
        done({"build", input_, model, "--order", order, "--placement", placement}).at("order"),
        order);
    static_cast<void>(done({"verify", model, "--against", input_}));
    static_cast<void>(done({"extract", model, output_, "--mesh", "--max-error", "0"}));
    EXPECT_EQ(sorted_cells(read(output_)), sorted_cells(read(input_)));
  }
}

}  // namespace
}  // namespace lode::test
