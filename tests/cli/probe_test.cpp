// `lode probe`: values at points and along lines, and integrals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

class cli_probe : public testing::Test {
 protected:
  cli_probe() {
    const TetraMesh noise = oracles::noise_mesh(10, oracles::Cut::in_five, 3);
    SimplexMesh mesh;
    mesh.positions = noise.positions;
    mesh.values = noise.fields[0].values;
    mesh.tetrahedra = noise.tetrahedra;
    mesh.errors.assign(mesh.tetrahedra.size(), 0);
    for (const auto& t : mesh.tetrahedra)
      mesh.regions.push_back(mesh.positions[t[0]][0] < 0.5 ? 2 : 5);
    Progress progress;
    EXPECT_TRUE(write_vtu(mesh_, mesh, {.value_name = "noise"}, progress));
    const Finished build = run_lode({"build", mesh_, lode_, "--field", "noise"});
    EXPECT_EQ(build.exit_code, 0) << build.err;
  }

  [[nodiscard]] nlohmann::json report(std::vector<std::string> options) const {
    options.insert(options.begin(), {"probe", lode_});
    options.emplace_back("--json");
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }

  Scratch scratch_;
  std::string mesh_ = scratch_ / "noise.vtu";
  std::string lode_ = scratch_ / "noise.lode";
};

std::vector<std::vector<std::string>> rows_of(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream text(line);
    auto& row = rows.emplace_back();
    for (std::string cell; std::getline(text, cell, ',');) row.push_back(cell);
  }
  return rows;
}

TEST_F(cli_probe, gives_what_vtk_gives) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  oracles::Random random(4);
  const std::string path = scratch_ / "points.csv";
  std::ofstream points(path);
  for (int i = 0; i < 200; ++i)
    points << random.uniform(-0.1, 1.1) << ',' << random.uniform(-0.1, 1.1) << ','
           << random.uniform(-0.1, 1.1) << '\n';
  points.close();
  const std::string output = scratch_ / "out.csv";
  const nlohmann::json json = report({"--points", path, "-o", output});
  const nlohmann::json integral = report({"--integral"});
  std::istringstream seen(run_oracle(std::string(LODE_PROBE_ORACLE), mesh_ + " " + path));
  const auto rows = rows_of(output);
  ASSERT_EQ(rows.size(), 201U);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"x", "y", "z", "status", "value", "low", "high",
                                               "error", "region"}));
  ASSERT_EQ(json.at("points").size(), 200U);
  int n_outside = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    std::string value;
    ASSERT_TRUE(std::getline(seen, value));
    const nlohmann::json& point = json.at("points")[i];
    EXPECT_EQ(point.at("status"), value == "outside" ? "outside" : "exact");
    EXPECT_EQ(rows[i + 1][3], point.at("status"));
    if (value == "outside") {
      ++n_outside;
      EXPECT_FALSE(point.contains("value"));
      continue;
    }
    // VTK finds weights in doubles, and gives them back in the array's type.
    EXPECT_NEAR(point.at("value").get<double>(), std::stod(value), 1e-6);
    EXPECT_EQ(std::stod(rows[i + 1][4]), point.at("value").get<double>());
    EXPECT_LE(point.at("low"), point.at("value"));
    EXPECT_GE(point.at("high"), point.at("value"));
  }
  EXPECT_GT(n_outside, 20);
  EXPECT_EQ(json.at("outside"), n_outside);
  EXPECT_EQ(json.at("warnings").size(), 1U);
  std::string word;
  double volume = 0;
  double sum = 0;
  ASSERT_TRUE(seen >> word >> volume >> sum);
  EXPECT_NEAR(integral.at("volume").at("value").get<double>(), volume, 1e-12);
  EXPECT_NEAR(integral.at("integral").at("value").get<double>(), sum, 1e-7);
}

TEST_F(cli_probe, gives_the_same_of_mesh_and_file) {
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--point", "0.3,0.4,0.5", "--max-error", "0.1"},
        {"--line", "0,0,0:1,1,0.9"},
        {"--line", "-1,0.2,0.2:2,0.2,0.2:17"},
        {"--integral", "--box", "0,0.5,0.25,1,-3,0.7", "--max-error", "0.2"}}) {
    const nlohmann::json of_file = report(options);
    std::vector<std::string> words{"probe", mesh_, "--field", "noise", "--json"};
    words.insert(words.end(), options.begin(), options.end());
    const Finished built = run_lode(words);
    ASSERT_EQ(built.exit_code, 0) << built.err;
    for (const char* const key : {"points", "line", "integral", "volume", "maximum"})
      EXPECT_EQ(of_file.value(key, nlohmann::json()), built.json().value(key, nlohmann::json()));
    EXPECT_EQ(of_file.at("error_kind"), "at samples");
    EXPECT_LE(of_file.at("achieved_error"), of_file.at("max_error"));
  }
}

TEST_F(cli_probe, follows_lines_and_says_where_they_are_outside) {
  const nlohmann::json knots = report({"--line", "-1,0.21,0.33:2,0.21,0.33"}).at("line");
  ASSERT_GT(knots.size(), 9U);
  EXPECT_NEAR(knots.front().at("distance").get<double>(), 1, 1e-15);
  EXPECT_NEAR(knots.back().at("distance").get<double>(), 2, 1e-15);
  for (const auto& knot : knots) EXPECT_EQ(knot.at("part"), 0);
  const nlohmann::json points = report({"--line", "-1,0.21,0.33:2,0.21,0.33:7"}).at("line");
  ASSERT_EQ(points.size(), 7U);
  EXPECT_EQ(points[0].at("status"), "outside");
  EXPECT_EQ(points[3].at("status"), "exact");
  const Finished text = run_lode({"probe", lode_, "--line", "-1,0.21,0.33:2,0.21,0.33:7"});
  EXPECT_NE(text.out.find("outside"), std::string::npos);
  const nlohmann::json none = report({"--line", "3,3,3:4,4,4"});
  EXPECT_TRUE(none.at("line").empty());
  EXPECT_EQ(none.at("warnings")[0], "the line meets no cell");
}

TEST_F(cli_probe, integrates_over_regions_that_make_the_whole) {
  const nlohmann::json whole = report({"--integral"});
  EXPECT_NEAR(whole.at("volume").at("value").get<double>(), 1, 1e-14);
  double volume = 0;
  double integral = 0;
  for (const char* const region : {"2", "5"}) {
    const nlohmann::json part = report({"--integral", "--region", region});
    volume += part.at("volume").at("value").get<double>();
    integral += part.at("integral").at("value").get<double>();
    EXPECT_LE(part.at("mean").at("low"), part.at("mean").at("high"));
  }
  EXPECT_NEAR(volume, 1, 1e-14);
  EXPECT_NEAR(integral, whole.at("integral").at("value").get<double>(), 1e-14);
  const nlohmann::json none = report({"--integral", "--box", "3,4,3,4,3,4"});
  EXPECT_TRUE(none.at("integral").is_null());
  EXPECT_EQ(none.at("warnings").size(), 1U);
  const Finished unknown = run_lode({"probe", lode_, "--integral", "--region", "3"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_NE(unknown.err.find("expected one of 2, 5, got 3"), std::string::npos) << unknown.err;
  expect_refusal(run_lode({"probe", lode_, "--integral", "--region", "two"}), 1,
                 {lode_, "expected one of 2, 5, got two"});
}

TEST_F(cli_probe, reads_points_with_headings_and_refuses_what_are_none) {
  const std::string path = scratch_ / "points.csv";
  write_bytes(path, "x,y,z\r\n# a note\n0.5,0.5,0.5\r\n\n 0.25;0.25;0.25\n+1e-1 0.2\t0.3\n");
  const nlohmann::json json = report({"--points", path, "--point", "0.5,0.5,0.5"});
  ASSERT_EQ(json.at("points").size(), 4U);
  EXPECT_EQ(json.at("points")[0], json.at("points")[1]);
  EXPECT_EQ(json.at("points")[3].at("point")[0], 0.1);
  for (const char* const text : {"", "x,y,z\n", "1,2\n", "1,2,3,4\n", "0,0,0\nnan,0,0\n",
                                 "0,0,0\nx,y,z\n", "1,2,inf\n", "0,0,1e999\n", "0 0,0x1\n"}) {
    write_bytes(path, text);
    const Finished run = run_lode({"probe", lode_, "--points", path});
    EXPECT_EQ(run.exit_code, 1) << text;
    EXPECT_NE(run.err.find("points.csv"), std::string::npos) << run.err;
  }
  EXPECT_EQ(run_lode({"probe", lode_, "--points", scratch_ / "none.csv"}).exit_code, 1);
}

TEST_F(cli_probe, tells_how_far_the_boundary_is_off) {
  // A floor that is no plane.
  const TetraMesh noise = oracles::noise_mesh(13, oracles::Cut::in_five, 3);
  SimplexMesh mesh;
  mesh.positions = noise.positions;
  for (Vec3d& p : mesh.positions) p[2] += 0.3 * p[0] * p[0];
  mesh.values = noise.fields[0].values;
  mesh.tetrahedra = noise.tetrahedra;
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  Progress progress;
  const std::string input = scratch_ / "curved.vtu";
  const std::string model = scratch_ / "curved.lode";
  ASSERT_TRUE(write_vtu(input, mesh, {.value_name = "noise"}, progress));
  ASSERT_EQ(run_lode({"build", input, model, "--field", "noise", "--boundary-tolerance", "0.05"})
                .exit_code,
            0);
  EXPECT_NE(run_lode({"info", model}).out.find("boundary moved"), std::string::npos);
  const std::string output = scratch_ / "out.vtu";
  const Finished text = run_lode({"extract", model, output, "--mesh"});
  EXPECT_NE(text.out.find("off by up to"), std::string::npos);
  const Finished json = run_lode({"extract", model, output, "--mesh", "--json"});
  const double deviation = json.json().at("boundary_deviation").get<double>();
  EXPECT_GT(deviation, 0.001);
  // Points just above the floor, which the cut has not got everywhere.
  std::vector<std::string> words{"probe", model, "--max-error", "10", "--json", "--quiet"};
  for (int i = 0; i < 200; ++i) {
    const double x = 0.005 * i;
    words.emplace_back("--point");
    words.push_back(fmt::format("{},0.5,{}", x, 0.3 * x * x + 0.0005));
  }
  const Finished run = run_lode(words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json answer = run.json();
  int n_near = 0;
  for (const nlohmann::json& point : answer.at("points")) {
    if (point.at("status") != "near boundary") continue;
    ++n_near;
    EXPECT_FALSE(point.contains("value"));
    EXPECT_LE(point.at("low"), point.at("high"));
  }
  EXPECT_EQ(answer.at("near_boundary"), n_near);
  EXPECT_GT(n_near, 0);
}

/// The noise, its square, and a vector whose name has a comma.
std::string write_fields(const std::string& path) {
  const TetraMesh noise = oracles::noise_mesh(10, oracles::Cut::in_five, 3);
  SimplexMesh mesh;
  mesh.positions = noise.positions;
  mesh.values = noise.fields[0].values;
  mesh.tetrahedra = noise.tetrahedra;
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  for (const auto& t : mesh.tetrahedra)
    mesh.regions.push_back(mesh.positions[t[0]][0] < 0.5 ? 2 : 5);
  mesh.attributes = {{"square", false, {}}, {"x, y", false, {}}};
  for (std::size_t v = 0; v < mesh.values.size(); ++v) {
    mesh.attributes[0].values.push_back(mesh.values[v] * mesh.values[v]);
    mesh.attributes[1].values.push_back(mesh.positions[v][0] + 2 * mesh.positions[v][1]);
  }
  Progress progress;
  EXPECT_TRUE(write_vtu(path, mesh, {.value_name = "noise"}, progress));
  return path;
}

/// With the fields of write_fields(), and a file of them.
class cli_probe_with : public cli_probe {
 protected:
  cli_probe_with() {
    const Finished build = run_lode({"build", mesh_of_all_, model_, "--field", "noise", "--with",
                                     names_[0], "--with", names_[1]});
    EXPECT_EQ(build.exit_code, 0) << build.err;
  }
  static nlohmann::json answer(const std::string& file, Words options) {
    options.insert(options.begin(), {"probe", file, "--json"});
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  [[nodiscard]] Words with_all(Words options) const {
    options.insert(options.end(), {"--field", "noise", "--with", names_[0], "--with", names_[1]});
    return options;
  }

  std::vector<std::string> names_{"square", "x, y"};
  std::string mesh_of_all_ = write_fields(scratch_ / "fields.vtu");
  std::string model_ = scratch_ / "fields.lode";
};

TEST_F(cli_probe_with, further_fields_gives_of_each_what_it_is_alone) {
  for (const Words& where :
       {Words{"--point", "0.31,0.42,0.53", "--point", "0.2,0.2,0.2", "--point", "3,0,0"},
        {"--line", "0,0.1,0.2:1,0.9,0.8"},
        {"--line", "-1,0.2,0.2:2,0.2,0.2:9"}}) {
    // At full resolution, in memory as in a file.
    const nlohmann::json together = answer(model_, with_all(where));
    const char* const key = where[0] == "--line" ? "line" : "points";
    EXPECT_EQ(together.at(key), answer(mesh_of_all_, with_all(where)).at(key));
    for (std::size_t f = 0; f < 2; ++f) {
      Words one = where;
      one.insert(one.end(), {"--field", names_[f]});
      const nlohmann::json alone = answer(model_, one);
      ASSERT_EQ(alone.at(key).size(), together.at(key).size());
      for (std::size_t i = 0; i < alone.at(key).size(); ++i) {
        const nlohmann::json& point = together.at(key)[i];
        const nlohmann::json& more = point.at("with")[f];
        EXPECT_EQ(more.at("field"), names_[f]);
        EXPECT_EQ(more.contains("value"), point.at("status") != "outside");
        for (const char* const number : {"value", "low", "high"})
          EXPECT_EQ(more.value(number, nlohmann::json()),
                    alone.at(key)[i].value(number, nlohmann::json()));
      }
    }
  }
}

TEST_F(cli_probe_with, further_fields_of_a_coarse_cut_have_bounds_that_hold) {
  Words where;
  for (int i = 0; i < 50; ++i)
    where.insert(where.end(),
                 {"--point", fmt::format("{},{},{}", 0.02 * i, 0.013 * i, 0.9 - 0.01 * i)});
  const nlohmann::json exact = answer(model_, with_all(where));
  where.insert(where.end(), {"--max-error", "0.3"});
  const nlohmann::json bounded = answer(model_, with_all(where));
  int n_bounded = 0;
  for (std::size_t i = 0; i < 50; ++i)
    for (std::size_t f = 0; f < 2; ++f) {
      const nlohmann::json& bounds = bounded.at("points")[i].at("with")[f];
      const double value = exact.at("points")[i].at("with")[f].at("value");
      EXPECT_LE(bounds.at("low").get<double>(), value + 1e-12);
      EXPECT_GE(bounds.at("high").get<double>(), value - 1e-12);
      if (bounded.at("points")[i].at("status") == "bounded") ++n_bounded;
    }
  EXPECT_GT(n_bounded, 20);
  EXPECT_EQ(bounded.at("with")[0].at("field"), "square");
  EXPECT_GT(bounded.at("with")[0].at("achieved_error"), 0);
}

TEST_F(cli_probe_with, further_fields_are_integrated_and_written_in_one_table) {
  const std::string output = scratch_ / "out.csv";
  const auto run = [&](Words options) {
    options.insert(options.begin(), {"-o", output});
    return answer(mesh_of_all_, with_all(options));
  };
  const nlohmann::json together = run({"--integral", "--region", "5"});
  for (std::size_t f = 0; f < 2; ++f) {
    const Finished alone = run_lode({"probe", mesh_of_all_, "--integral", "--region", "5",
                                     "--field", f == 0 ? "square" : "x, y", "--json"});
    for (const char* const key : {"integral", "mean", "minimum", "maximum"})
      EXPECT_NEAR(together.at("with")[f].at(key).at("value").get<double>(),
                  alone.json().at(key).at("value").get<double>(), 1e-12)
          << key;
    EXPECT_GT(together.at("with")[f].at("integral_rounding"), 0);
  }
  const std::string csv = read_bytes(output);
  for (const char* const row :
       {"\nvolume,", "\nmean,", "\nmean of square,", "\n\"maximum of x, y\","})
    EXPECT_NE(csv.find(row), std::string::npos) << csv;
  run({"--point", "0.5,0.5,0.5"});
  EXPECT_EQ(read_bytes(output).substr(0, read_bytes(output).find('\n')),
            "x,y,z,status,value,low,high,error,region,square,square low,square high,square error,"
            "\"x, y\",\"x, y low\",\"x, y high\",\"x, y error\"");
  EXPECT_TRUE(run({"--integral", "--box", "3,4,3,4,3,4"}).at("with")[0].at("mean").is_null());
}

TEST_F(cli_probe, refuses_what_has_no_answer) {
  const auto refused = [&](std::vector<std::string> options, const char* word) {
    options.insert(options.begin(), {"probe", lode_});
    expect_refusal(run_lode(options), 2, {word});
  };
  refused({}, "--point");
  refused({"--point", "1,2,3", "--integral"}, "several");
  refused({"--point", "1,2"}, "--point");
  refused({"--point", "1,2,nan"}, "--point");
  refused({"--line", "1,2,3"}, "--line");
  refused({"--line", "1,2,3:1,2,3"}, "different");
  refused({"--line", "1,2,3:1,2,4:1"}, "--line");
  refused({"--line", "1,2,3:1,2,4:9:9"}, "--line");
  refused({"--integral", "--box", "0,1,0,1,1,1"}, "--box");
  refused({"--integral", "--box", "0,1,0,1"}, "--box");
  refused({"--point", "0,0,0", "--box", "0,1,0,1,0,1"}, "--box");
  refused({"--point", "0,0,0", "--region", "2"}, "--region");
  refused({"--integral", "--max-error", "-1"}, "--max-error");
  refused({"--integral", "-o", "out.txt"}, ".csv");
  refused({"--integral", "--dims", "3x3x3"}, "--dims");
  expect_refusal(run_lode({"probe", scratch_ / "none.lode", "--point", "0,0,0"}), 2,
                 {"none.lode", "cannot open"});
  const Finished nowhere = run_lode({"probe", lode_, "--integral", "-o", "/none/such/out.csv"});
  EXPECT_EQ(nowhere.exit_code, 1);
}

}  // namespace
}  // namespace lode::test
