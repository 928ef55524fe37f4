#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tests/io/cell_mesh_files.h"

namespace lode::io {
namespace {

/// A field of a file and the range that the README of the data states.
struct RealField {
  const char* name;
  ScalarType type;
  double low;
  double high;
  int n_components = 1;
};

struct RealMesh {
  const char* name;
  CellType type;
  std::size_t n_cells;
  std::size_t n_points;
  std::vector<RealField> point_fields;
  std::vector<RealField> cell_fields = {};
};

const MeshField* find_field(const std::vector<MeshField>& fields, const std::string& name) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const MeshField& field) { return field.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

void expect_fields(const std::vector<MeshField>& fields, const std::vector<RealField>& expected) {
  EXPECT_EQ(fields.size(), expected.size());
  for (const RealField& real : expected) {
    const MeshField* field = find_field(fields, real.name);
    ASSERT_NE(field, nullptr) << real.name;
    EXPECT_EQ(field->type, real.type);
    EXPECT_EQ(field->n_components, real.n_components);
    const auto [low, high] = std::minmax_element(field->values.begin(), field->values.end());
    // The README prints six digits or more.
    EXPECT_NEAR(*low, real.low, 5e-6 * std::abs(real.low)) << real.name;
    EXPECT_NEAR(*high, real.high, 5e-6 * std::abs(real.high)) << real.name;
  }
}

class real_meshes : public testing::TestWithParam<RealMesh> {};

TEST_P(real_meshes, have_the_counts_and_ranges_of_the_readme) {
  const RealMesh& real = GetParam();
  const std::string path = (test::data_directory() / "tetra" / real.name).string();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  const CellMesh mesh = test::read_mesh(path);
  EXPECT_EQ(mesh.points.size(), real.n_points);
  EXPECT_EQ(mesh.n_cells(), real.n_cells);
  EXPECT_TRUE(mesh.has_narrow_points);
  const auto n = std::count(mesh.types.begin(), mesh.types.end(), static_cast<int>(real.type));
  EXPECT_EQ(static_cast<std::size_t>(n), real.n_cells);
  expect_fields(mesh.point_fields, real.point_fields);
  expect_fields(mesh.cell_fields, real.cell_fields);
}

constexpr auto kFloat = ScalarType::float32;
constexpr auto kDouble = ScalarType::float64;

std::vector<RealField> blunt_fin_fields() {
  return {{"Density", kFloat, 0.1926, 4.9775},
          {"StagnationEnergy", kFloat, 0.76895696, 25.161},
          {"Momentum", kFloat, -3.7339, 5.7903, 3}};
}

std::vector<RealField> oxygen_post_fields() {
  return {{"StagnationEnergy", kFloat, -0.5415063, 4.3958373},
          {"Momentum", kFloat, -0.67563146, 1.3617545, 3}};
}

INSTANTIATE_TEST_SUITE_P(
    readme, real_meshes,
    testing::Values(RealMesh{"disk_out_44832tets.vtu",
                             CellType::tetrahedron,
                             44832,
                             8499,
                             {{"Temp", kDouble, 293.15, 913.15},
                              {"Pres", kDouble, 0.00678552, 0.0288185},
                              {"AsH3", kDouble, 0.0804768, 0.184839},
                              {"GaMe3", kDouble, 0.000222844, 0.00721393},
                              {"CH4", kDouble, 0, 0.00117024},
                              {"H2", kDouble, 0.807613, 0.917688},
                              {"V", kDouble, -21.126, 19.9491, 3}}},
                    RealMesh{"turbulence_60672tets.vtu",
                             CellType::tetrahedron,
                             60672,
                             21813,
                             {{"tur_mu", kFloat, 1.8720104e-06, 0.000104124425}}},
                    RealMesh{"blunt_fin_curvilinear_40x32x32.vts", CellType::hexahedron, 37479,
                             40960, blunt_fin_fields()},
                    RealMesh{"blunt_fin_187395tets.vtu", CellType::tetrahedron, 187395, 40960,
                             blunt_fin_fields()},
                    RealMesh{"fea_kiefer_56786quadtets.vtu",
                             CellType::quadratic_tetrahedron,
                             56786,
                             102578,
                             {},
                             {{"Equivalent (von-Mises) Stress (psi)", kFloat, 0.014035, 23.269}}},
                    RealMesh{"bracket_206208tets.vtu",
                             CellType::tetrahedron,
                             206208,
                             50000,
                             {{"xdsp", kFloat, -9.53617e-09, 3.23773e-07},
                              {"ydsp", kFloat, -1.84582e-08, 3.61713e-08},
                              {"zdsp", kFloat, -4.57606e-08, 7.66032e-08}},
                             {{"sj2p", kFloat, 216.084, 119441},
                              {"Material #", ScalarType::int32, 1, 1}}},
                    RealMesh{"oxygen_post_curvilinear_38x76x38.vts", CellType::hexahedron, 102675,
                             109744, oxygen_post_fields()},
                    RealMesh{"oxygen_post_513375tets.vtu", CellType::tetrahedron, 513375, 109744,
                             oxygen_post_fields()}),
    [](const testing::TestParamInfo<RealMesh>& mesh) {
      const std::string name = mesh.param.name;
      return name.substr(0, name.find_first_of("0123456789.")) + std::to_string(mesh.index);
    });

}  // namespace
}  // namespace lode::io
