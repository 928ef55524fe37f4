// Formats that lode-vtk-import reads, through the program; and what lode makes of one that fails.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"

namespace lode::test {
namespace {

std::string importer() {
  return (std::filesystem::path(LODE_PROGRAM).parent_path() / "lode-vtk-import").string();
}

/// A fixture of make_fixtures.py: 4 x 2 x 2 hexahedra over [0, 4] x [0, 2] x [0, 2].
struct Import {
  const char* file;
  const char* field;
  double offset = 0;  ///< Of the field, from x + 2 y + 4 z, at the last step.
  std::vector<std::int64_t> regions;
  int n_cells = 16;
  int n_points = 54;  ///< Two blocks with 9 points in one place; 45 where they share these.
  int n_faces = 0;    ///< Of patches.
  const char* patch = "";
};

std::ostream& operator<<(std::ostream& out, const Import& import) { return out << import.file; }

class imported : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(importer()))
      GTEST_SKIP() << "lode-vtk-import is not built; it needs libvtk9-dev";
    ASSERT_TRUE(has_vtk()) << kVtkMissing;
  }
  /// Fixtures of make_fixtures.py, by their names.
  void make(const std::string& names) const {
    ASSERT_EQ(run_oracle(LODE_IMPORT_FIXTURES, scratch_.path() + " " + names), "");
  }
  nlohmann::json report(Words words) const {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  [[nodiscard]] TetrahedraOutcome extracted(const std::string& input, Words options) const {
    const std::string output = scratch_ / "out.vtu";
    options.insert(options.begin(), {"extract", input, output, "--mesh", "--max-error", "0"});
    report(options);
    auto cells = read_cell_mesh(output, {});
    EXPECT_TRUE(cells);
    auto made = to_tetrahedra(std::move(*cells), {});
    EXPECT_TRUE(made);
    return std::move(*made);
  }

  Scratch scratch_;
};

class vtk_import : public imported, public testing::WithParamInterface<Import> {
 protected:
  void SetUp() override {
    imported::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) make(GetParam().file);
  }
};

std::map<std::int64_t, double> volumes_of(const TetraMesh& mesh) {
  std::map<std::int64_t, double> volumes;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    const auto& [a, b, c, d] = mesh.tetrahedra[i];
    const auto& p = mesh.positions;
    volumes[mesh.regions.empty() ? 0 : mesh.region_ids.at(mesh.regions[i])] +=
        dot(cross(p[b] - p[a], p[c] - p[a]), p[d] - p[a]) / 6;
  }
  return volumes;
}

TEST_P(vtk_import, gives_points_cells_values_and_regions) {
  const Import& import = GetParam();
  const std::string input = scratch_ / import.file;
  const nlohmann::json info = report({"info", input});
  EXPECT_EQ(info.at("cells"), import.n_cells + import.n_faces);
  EXPECT_EQ(info.at("reading").at("patch_faces"), import.n_faces);
  EXPECT_EQ(info.at("reading").at("inner_faces"), 0);
  ASSERT_EQ(info.at("patches").size(), import.n_faces > 0 ? 1U : 0U);
  if (import.n_faces > 0) EXPECT_EQ(info.at("patches")[0].at("name"), import.patch);
  EXPECT_EQ(info.at("points"), import.n_points);
  EXPECT_EQ(info.at("reading").at("coincident_points"), import.n_points == 54 ? 9 : 0);
  EXPECT_EQ(info.at("reading").at("hidden_cells"), 16 - import.n_cells);
  const TetraMesh mesh = extracted(input, {"--field", import.field}).mesh;
  ASSERT_EQ(mesh.fields.size(), 1U);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d& p = mesh.positions[v];
    EXPECT_NEAR(mesh.fields[0].values[v], p[0] + 2 * p[1] + 4 * p[2] + import.offset, 1e-5);
  }
  const auto volumes = volumes_of(mesh);
  ASSERT_EQ(volumes.size(), std::max<std::size_t>(import.regions.size(), 1));
  double all = 0;
  for (const auto& [region, volume] : volumes) all += volume;
  EXPECT_NEAR(all, import.n_cells, 1e-9);
  for (const std::int64_t region : import.regions)
    EXPECT_NEAR(volumes.at(region), import.n_cells == 16 || region == 1 ? 8 : 7, 1e-9);
}

TEST_P(vtk_import, comes_into_lode_files_that_are_verified_against_it) {
  const Import& import = GetParam();
  const std::string input = scratch_ / import.file;
  const std::string model = scratch_ / "x.lode";
  report({"build", input, model, "--field", import.field, "--weld", "0"});
  const nlohmann::json info = report({"info", model});
  EXPECT_EQ(info.at("vertices"), import.n_cells == 16 ? 45 : 44);
  const nlohmann::json verified =
      report({"verify", model, "--against", input, "--field", import.field, "--weld", "0"});
  EXPECT_EQ(verified.at("passed"), true);
}

INSTANTIATE_TEST_SUITE_P(all, vtk_import,
                         testing::Values(Import{"blocks.e", "f", 100, {10, 20}, 16, 45},
                                         Import{"blocks.cgns", "f", 0, {1, 2}, 16, 54, 4, "Wall"},
                                         Import{
                                             "ensight.case", "f", 100, {1, 2}, 16, 54, 2, "wall"},
                                         Import{"plot3d.xyz", "Density", 1, {1, 2}, 15},
                                         Import{"lz4.vtu", "f", 0, {10, 20}, 16, 45},
                                         Import{"lzma.vts", "f", 0, {10, 20}, 16, 45},
                                         Import{"parts.pvtu", "f", 0, {10, 20}, 16, 54},
                                         Import{"parts.pvts", "f", 0, {10, 20}, 16, 45},
                                         Import{"blocks.vtm", "f", 0, {1, 2}, 16, 54, 1, "wall"}),
                         [](const auto& format) {
                           return std::filesystem::path(format.param.file).stem().string() +
                                  std::to_string(format.index);
                         });

class vtk_import_of : public imported {};

TEST_F(vtk_import_of, foam_cases_has_polyhedra_and_values_of_cells) {
  make("foam");
  const std::string input = scratch_ / "foam";
  const nlohmann::json info = report({"info", input});
  EXPECT_EQ(info.at("cells"), 16 + 40);
  EXPECT_EQ(info.at("points"), 45);
  EXPECT_EQ(info.at("patches")[0].at("name"), "walls");
  EXPECT_EQ(info.at("reading").at("patch_faces"), 40);
  EXPECT_EQ(info.at("reading").at("new_points"), 2);
  // The means of our own rule: 100 of the step and at most 12.5 in the corner's cell.
  EXPECT_EQ(info.at("reading").at("averaged")[0].at("cell_max"), 112.5);
  EXPECT_EQ(info.at("reading").at("averaged")[0].at("point_max"), 112.5);
  const TetraMesh mesh = extracted(input, {"--field", "p"}).mesh;
  EXPECT_NEAR(volumes_of(mesh).at(0), 16, 1e-9);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d& p = mesh.positions[v];
    if (p == Vec3d{{2, 1, 1}}) EXPECT_NEAR(mesh.fields[0].values[v], 108, 1e-4);
  }
}

TEST_F(vtk_import_of, steps_takes_the_last_unless_told) {
  make("blocks.e ensight.case");
  for (const auto& [file, field] : {std::pair{"blocks.e", "f"}, {"ensight.case", "f"}}) {
    const std::string input = scratch_ / file;
    const TetraMesh mesh = extracted(input, {"--field", field, "--time", "0"}).mesh;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3d& p = mesh.positions[v];
      EXPECT_NEAR(mesh.fields[0].values[v], p[0] + 2 * p[1] + 4 * p[2], 1e-5);
    }
    const Finished last = run_lode({"info", input});
    EXPECT_NE(last.err.find("step 1 of 0 to 1 (time 0.5)"), std::string::npos) << last.err;
    expect_refusal(run_lode({"info", input, "--time", "2"}), 1,
                   {file, "expected a step from 0 to 1, got 2"});
    expect_refusal(run_lode({"info", input, "--time", "x"}), 2, {"--time"});
  }
}

TEST_F(vtk_import_of, what_lode_wrote_has_its_regions_and_values) {
  make("blocks.e");
  const std::string exodus = scratch_ / "out.e";
  report({"extract", scratch_ / "blocks.e", exodus, "--mesh", "--max-error", "0"});
  const TetraMesh mesh = extracted(exodus, {"--field", "f"}).mesh;
  EXPECT_EQ(mesh.region_ids, (std::vector<std::int64_t>{10, 20}));
  EXPECT_EQ(mesh.positions.size(), 45U);
  EXPECT_NEAR(volumes_of(mesh).at(20), 8, 1e-9);
  EXPECT_NEAR(report({"probe", exodus, "--field", "f", "--integral"})
                  .at("volume")
                  .at("value")
                  .get<double>(),
              volumes_of(mesh).at(10) + 8, 1e-9);
}

TEST_F(vtk_import_of, elements_whose_nodes_vtk_takes_for_others_are_refused) {
  make("elements.e");
  expect_refusal(run_lode({"info", scratch_ / "elements.e"}), 1,
                 {"elements.e", "block 1", "TETRA14", "4, 10 nodes", "got 14"});
}

TEST_F(vtk_import_of, steps_gives_their_times) {
  make("blocks.e ensight.case");
  for (const char* const file : {"blocks.e", "ensight.case"}) {
    const std::string input = scratch_ / file;
    const std::string model = scratch_ / "first.lode";
    report({"build", input, model, "--field", "f", "--time", "0", "--weld", "0"});
    const nlohmann::json attached = report({"attach-field", model, input, scratch_ / "all.lode",
                                            "--field", "f", "--time", "0,1", "--weld", "0"});
    ASSERT_EQ(attached.at("fields").size(), 3U);
    EXPECT_EQ(attached.at("fields")[1].at("time"), 0);
    EXPECT_EQ(attached.at("fields")[2].at("time"), 0.5);
  }
}

TEST_F(vtk_import_of, blocks_gives_regions_their_names) {
  make("ensight.case blocks.vtm blocks.cgns plot3d.xyz blocks.e");
  const auto names_of = [&](const std::string& file) {
    return report({"info", scratch_ / file}).at("region_names");
  };
  EXPECT_EQ(names_of("ensight.case"), nlohmann::json({"inlet", "outlet"}));
  EXPECT_EQ(names_of("blocks.vtm"), nlohmann::json({"left", "right"}));
  EXPECT_EQ(names_of("blocks.cgns"), nlohmann::json({"Inlet", "Outlet"}));
  // Without names of its own; and one of Lode's, which has them.
  EXPECT_EQ(names_of("plot3d.xyz"), nlohmann::json({"", ""}));
  EXPECT_EQ(names_of("blocks.e"), nlohmann::json({"", ""}));
  report({"extract", scratch_ / "ensight.case", scratch_ / "out.e", "--mesh", "--max-error", "0",
          "--field", "f"});
  EXPECT_EQ(names_of("out.e"), nlohmann::json({"inlet", "outlet"}));
  const std::string part = scratch_ / "part.vtu";
  report({"extract", scratch_ / "out.e", part, "--mesh", "--max-error", "0", "--field", "f",
          "--region", "outlet"});
  EXPECT_EQ(report({"info", part}).at("regions"), nlohmann::json({2}));
}

TEST_F(vtk_import_of, patches_come_with_their_names_through_files_and_exodus) {
  make("foam");
  const std::string model = scratch_ / "foam.lode";
  report({"build", scratch_ / "foam", model, "--field", "p"});
  const std::string exodus = scratch_ / "out.e";
  report({"extract", model, exodus, "--mesh", "--max-error", "0"});
  const nlohmann::json info = report({"info", exodus});
  ASSERT_EQ(info.at("patches").size(), 1U);
  EXPECT_EQ(info.at("patches")[0].at("name"), "walls");
  EXPECT_EQ(info.at("reading").at("patch_faces"), 80);
  EXPECT_EQ(info.at("reading").at("inner_faces"), 0);
}

TEST_F(vtk_import_of, damaged_files_fails_with_one_sentence) {
  make("blocks.e blocks.cgns ensight.case plot3d.xyz");
  const std::string grid = read_bytes(scratch_ / "plot3d.xyz");
  for (const char* const file : {"blocks.e", "blocks.cgns", "ensight.case", "plot3d.xyz"}) {
    const std::string input = scratch_ / file;
    const std::string whole = read_bytes(input);
    for (const std::string& damaged :
         {whole.substr(0, whole.size() / 2), std::string("nothing of the kind"), std::string()}) {
      write_bytes(input, damaged);
      expect_refusal(run_lode({"info", input, "--quiet"}), 1, {file});
    }
  }
  // Text of that name would be points.
  write_bytes(scratch_ / "plot3d.xyz", grid);
  std::filesystem::remove(scratch_ / "plot3d.q");
  expect_refusal(run_lode({"info", scratch_ / "plot3d.xyz"}), 1, {"plot3d.q beside the grid"});
  expect_refusal(run_lode({"info", scratch_ / "absent.e"}), 1, {"absent.e", "found none"});
}

/// lode somewhere else, where what is called lode-vtk-import is a script, or nothing.
class other_importer : public testing::Test {
 protected:
  other_importer() {
    std::filesystem::copy(LODE_PROGRAM, scratch_ / "lode");
    write_bytes(scratch_ / "a.cgns", "");
  }
  void write_importer(const std::string& script) const {
    write_bytes(scratch_ / "lode-vtk-import", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(scratch_ / "lode-vtk-import", std::filesystem::perms::owner_all);
  }
  /// What info of a file says, with its temporary files in a folder that must be empty afterwards.
  [[nodiscard]] std::string said(const std::string& name = "a.cgns") const {
    std::filesystem::create_directory(scratch_ / "tmp");
    const std::string text =
        output_of("cd " + scratch_.path() + " && TMPDIR=" + (scratch_ / "tmp") +
                  " PATH=/nonexistent ./lode info " + name + " 2>&1; echo \"exit $?\"");
    EXPECT_TRUE(std::filesystem::is_empty(scratch_ / "tmp"));
    return text;
  }

  Scratch scratch_;
};

TEST_F(other_importer, that_is_not_there_is_asked_for) {
  const std::string text = said();
  EXPECT_NE(text.find("a.cgns: expected the program lode-vtk-import"), std::string::npos) << text;
  EXPECT_NE(text.find("libvtk9-dev"), std::string::npos) << text;
  EXPECT_NE(text.find("exit 1"), std::string::npos) << text;
}

TEST_F(other_importer, is_asked_for_what_is_packed_as_lode_cannot_unpack) {
  for (const char* const name : {"a.vtu", "a.vts", "a.pvtu", "a.pvts", "a.vtm"}) {
    write_bytes(scratch_ / name,
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" "
                "compressor=\"vtkLZ4DataCompressor\">\n</VTKFile>\n");
    EXPECT_NE(said(name).find(std::string(name) + ": expected the program lode-vtk-import"),
              std::string::npos);
  }
}

TEST_F(other_importer, that_fails_or_dies_or_lies_leaves_an_error) {
  write_importer("echo one >&2; echo two >&2; exit 1");
  EXPECT_EQ(said(), "lode: a.cgns: two\nexit 1\n");
  write_importer("exit 3");
  EXPECT_EQ(said(),
            "lode: a.cgns: lode-vtk-import ended with exit code 3: it said nothing\nexit 1\n");
  write_importer("kill -9 $$");
  EXPECT_EQ(said(),
            "lode: a.cgns: lode-vtk-import ended with exit code 137: it said nothing\nexit 1\n");
  write_importer("exit 0");
  EXPECT_NE(said().find("as lode-vtk-import gives it: "), std::string::npos);
  write_importer("echo junk > $2");
  EXPECT_NE(said().find("as lode-vtk-import gives it: "), std::string::npos);
}

TEST_F(other_importer, that_takes_long_is_ended_with_lode) {
  write_importer("echo $$ > ../pid; exec /bin/sleep 50");
  std::filesystem::create_directories(scratch_ / "tmp");
  const std::string text = output_of("cd " + (scratch_ / "tmp") +
                                     " && TMPDIR=. /usr/bin/timeout -s TERM 0.5 ../lode info " +
                                     "../a.cgns 2>&1; echo \"exit $?\"");
  EXPECT_NE(text.find("lode: stopped; "), std::string::npos) << text;
  EXPECT_NE(text.find("exit 124"), std::string::npos) << text;  // what timeout says
  EXPECT_TRUE(std::filesystem::is_empty(scratch_ / "tmp"));
  const std::string pid = read_bytes(scratch_ / "pid");
  ASSERT_FALSE(pid.empty());
  EXPECT_FALSE(std::filesystem::exists("/proc/" + pid.substr(0, pid.find('\n'))));
}

}  // namespace
}  // namespace lode::test
