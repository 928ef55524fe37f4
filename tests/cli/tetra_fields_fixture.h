#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {

/// A mesh with noise, its square, and a vector.
inline void write_step(const std::string& path, double factor) {
  const TetraMesh noise = oracles::noise_mesh(9, oracles::Cut::in_six, 3);
  std::ofstream file(path);
  file.precision(17);
  file << "# vtk DataFile Version 3.0\nstep\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS "
       << noise.positions.size() << " double\n";
  for (const Vec3d& p : noise.positions) file << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  file << "CELLS " << noise.tetrahedra.size() << ' ' << 5 * noise.tetrahedra.size() << '\n';
  for (const auto& t : noise.tetrahedra)
    file << "4 " << t[0] << ' ' << t[1] << ' ' << t[2] << ' ' << t[3] << '\n';
  file << "CELL_TYPES " << noise.tetrahedra.size() << '\n';
  for (std::size_t i = 0; i < noise.tetrahedra.size(); ++i) file << "10\n";
  file << "POINT_DATA " << noise.positions.size() << "\nSCALARS noise double 1\n"
       << "LOOKUP_TABLE default\n";
  for (const double v : noise.fields[0].values) file << factor * v << '\n';
  file << "SCALARS square double 1\nLOOKUP_TABLE default\n";
  for (const double v : noise.fields[0].values) file << factor * v * v << '\n';
  file << "VECTORS shift double\n";
  for (const Vec3d& p : noise.positions)
    file << 0.1 * factor * p[2] << " 0 " << 0.2 * p[0] * p[1] << '\n';
}

class cli_tetra_fields : public testing::Test {
 protected:
  cli_tetra_fields() {
    write_step(mesh_, 1);
    write_step(later_, 2);
    write_step(latest_, 3);
    EXPECT_EQ(run_lode({"build", mesh_, model_, "--field", "noise", "--with", "square", "--with",
                        "shift:x"})
                  .exit_code,
              0);
  }
  static nlohmann::json done(std::vector<std::string> words) {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  static void refused(const std::vector<std::string>& words, const std::string& why) {
    const Finished run = run_lode(words);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  }
  /// Names of a file's point fields.
  static std::vector<std::string> fields_of(const std::string& path) {
    const auto cells = read_cell_mesh(path, {});
    EXPECT_TRUE(cells);
    std::vector<std::string> names;
    for (const MeshField& field : cells->point_fields) names.push_back(field.name);
    return names;
  }

  Scratch scratch_;
  std::string mesh_ = scratch_ / "one.vtk";
  std::string later_ = scratch_ / "two.vtk";
  std::string latest_ = scratch_ / "three.vtk";
  std::string model_ = scratch_ / "model.lode";
  std::string out_ = scratch_ / "out.vtu";
};

}  // namespace lode::test
