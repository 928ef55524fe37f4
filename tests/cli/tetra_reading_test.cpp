// What is chosen of a mesh of cells, and told of it, when the program reads one.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

class cli_tetra_reading : public testing::Test {
 protected:
  /// Two tetrahedra of one face, and a point of no cell before theirs; `first` is the value there
  /// where they begin.
  void write(const std::string& first) const {
    write_bytes(input_,
                fmt::format("# vtk DataFile Version 3.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                            "POINTS 6 double\n9 9 9 0 0 0 1 0 0 0 1 0 0 0 1 0 0 -1\n"
                            "CELLS 2 10\n4 1 2 3 4\n4 1 3 2 5\nCELL_TYPES 2\n10 10\n"
                            "CELL_DATA 2\nSCALARS Material int 1\nLOOKUP_TABLE default\n9 9\n"
                            "SCALARS blade int 1\nLOOKUP_TABLE default\n4 5\n"
                            "POINT_DATA 6\nSCALARS t double 1\nLOOKUP_TABLE default\n0 {} 1 2 3 4\n"
                            "FIELD more 2\nv 3 6 double\n{}\nw 4 6 double\n{}\n",
                            first, numbers(18), numbers(24)));
  }
  static std::string numbers(int n) {
    std::string text;
    for (int i = 0; i < n; ++i) text += fmt::format("{} ", i % 7);
    return text;
  }
  nlohmann::json report(Words words) const {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  static void refused(const Words& words, const std::string& why) {
    const Finished run = run_lode(words);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.vtk";
  std::string model_ = scratch_ / "x.lode";
};

TEST_F(cli_tetra_reading, takes_regions_from_the_field_that_is_named) {
  write("0");
  EXPECT_EQ(report({"info", input_}).at("regions"), nlohmann::json({9}));
  EXPECT_EQ(report({"info", input_, "--region-field", "blade"}).at("regions"),
            nlohmann::json({4, 5}));
  EXPECT_EQ(
      report({"build", input_, model_, "--field", "t", "--region-field", "blade"}).at("regions"),
      nlohmann::json({4, 5}));
  EXPECT_EQ(report({"probe", model_, "--integral", "--region", "5"}).at("volume").at("value"),
            1.0 / 6);
  refused({"info", input_, "--region-field", "t"}, "(Material, blade), got 't'");
  refused({"info", model_, "--region-field", "blade"}, "--field, --with and --time");
}

TEST_F(cli_tetra_reading, says_which_values_are_not_finite_and_where) {
  write("nan");
  const nlohmann::json lacking = report({"info", input_}).at("reading").at("nonfinite");
  ASSERT_EQ(lacking.size(), 1U);
  EXPECT_EQ(lacking[0], (nlohmann::json{{"field", "t"}, {"values", 1}, {"first_point", 1}}));
  refused({"build", input_, model_, "--field", "t"}, "field t: expected finite values, got 1");
  refused({"build", input_, model_, "--field", "t"}, "at point 1 ");
  report({"build", input_, model_, "--field", "v"});
}

TEST_F(cli_tetra_reading, takes_three_components_for_a_vector) {
  write("0");
  report({"build", input_, model_, "--field", "t", "--with", "v:xyz"});
  refused({"build", input_, model_, "--field", "t", "--with", "w:xyz"}, "w has 4");
  refused({"build", input_, model_, "--field", "w:xyz"}, "w has 4");
  const nlohmann::json built = report({"build", input_, model_, "--field", "v:xyz"});
  ASSERT_EQ(built.at("fields").size(), 3U);
  EXPECT_EQ(built.at("fields")[2].at("name"), "v:2");
  const nlohmann::json cut =
      report({"extract", model_, scratch_ / "v.vtu", "--mesh", "--field", "v:xyz"});
  EXPECT_EQ(cut.at("field"), "v:0");
  EXPECT_EQ(cut.at("with").size(), 2U);
  report({"build", input_, model_, "--field", "t"});
  const std::string all = scratch_ / "all.lode";
  EXPECT_EQ(report({"attach-field", model_, input_, all, "--field", "v:xyz"}).at("attached"), 3);
  // Of another mesh that is said, whatever its fields are called.
  write_bytes(input_, [&] {
    std::string text = read_bytes(input_);
    return text.replace(text.find("9 9 9 0 0 0 1"), 13, "9 9 9 0 0 0 2");
  }());
  refused({"attach-field", model_, input_, all, "--field", "t"}, "vertex");
}

TEST_F(cli_tetra_reading, is_as_fine_as_a_transfer_function_shows_it) {
  const TetraMesh noise = oracles::noise_mesh(13, oracles::Cut::in_six, 5);
  SimplexMesh mesh;
  mesh.positions = noise.positions;
  mesh.values = noise.fields[0].values;
  mesh.tetrahedra = noise.tetrahedra;
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  const std::string input = scratch_ / "noise.vtu";
  Progress progress;
  ASSERT_TRUE(write_mesh(input, mesh, {.value_name = "noise"}, progress));
  report({"build", input, model_});
  auto values = mesh.values;
  std::ranges::sort(values);
  const double shown = values[values.size() * 9 / 10];
  const std::string knots = scratch_ / "upper.txt";
  const auto cells = [&](const Words& options) -> int {
    Words words{"extract", model_, scratch_ / "out.vtu", "--mesh", "--max-error", "1%"};
    words.insert(words.end(), options.begin(), options.end());
    const nlohmann::json cut = report(words);
    EXPECT_LE(cut.at("achieved_error"), cut.at("max_error"));
    return cut.at("cells");
  };
  // As within the values that it shows, where all of them count alike.
  write_bytes(knots, fmt::format("{} 1 0 0 0\n{} 1 0 0 1\n10 1 0 0 1\n", shown - 1e-6, shown));
  const int alike = cells({"--opacity", knots});
  EXPECT_LT(alike, cells({}));
  EXPECT_LE(cells({"--field-range", fmt::format("{}:10", shown)}), alike);
  EXPECT_GE(cells({"--field-range", fmt::format("{}:10", shown - 1e-6)}), alike);
  // Coarser where it shows less.
  write_bytes(knots, fmt::format("{} 1 0 0 0\n{} 1 0 0 1\n", shown, values.back()));
  const int coarse = cells({"--opacity", knots});
  EXPECT_LT(coarse, alike);
  // No coarser anywhere than is said, however clear it is there.
  const int bounded = cells({"--opacity", knots, "--max-error-outside", "10%"});
  const nlohmann::json info = report({"info", model_});
  const double range = info.at("range")[1].get<double>() - info.at("range")[0].get<double>();
  EXPECT_GT(bounded, coarse);
  const auto largest = [&](const Words& outside) {
    Words words{"extract",     model_, scratch_ / "out.vtu", "--mesh",
                "--max-error", "1%",   "--opacity",          knots};
    words.insert(words.end(), outside.begin(), outside.end());
    return report(words).at("largest_error").get<double>();
  };
  EXPECT_GT(largest({}), 0.1 * range);
  EXPECT_LE(largest({"--max-error-outside", "10%"}), 0.1 * range);
  EXPECT_EQ(cells({"--opacity", knots, "--max-error-outside", "1%"}), cells({}));
  const Words words{"extract", model_, scratch_ / "out.vtu", "--opacity", "fog"};
  refused(words, "--opacity: expected --mesh or --boundary with it");
  Words wanted = words;
  wanted.emplace_back("--mesh");
  refused(wanted, "expected one of viridis-smoke");
  refused(wanted, "got 'fog'; nor is there a file of that name");
}

}  // namespace
}  // namespace lode::test
