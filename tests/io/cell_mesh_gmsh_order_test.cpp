#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "lode/io/quadratic_cells.h"
#include "tests/io/tetra_checks.h"
#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::TempDir;

/// A quadratic element as the chapter on node ordering of Gmsh's manual draws it: nodes are
/// corners, then in the middles of edges, then of faces, then of the element.
struct GmshOrder {
  const char* name = "";
  int type = 0;
  std::vector<Vec3d> corners;
  std::vector<std::vector<std::size_t>> middles;  ///< Each between these corners.
  double volume = 0;
};

std::vector<Vec3d> cube() {
  return {{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}},
          {{0, 0, 1}}, {{1, 0, 1}}, {{1, 1, 1}}, {{0, 1, 1}}};
}

std::vector<GmshOrder> orders() {
  const std::vector<std::vector<std::size_t>> of_cube = {{0, 1},
                                                         {0, 3},
                                                         {0, 4},
                                                         {1, 2},
                                                         {1, 5},
                                                         {2, 3},
                                                         {2, 6},
                                                         {3, 7},
                                                         {4, 5},
                                                         {4, 7},
                                                         {5, 6},
                                                         {6, 7},
                                                         {0, 1, 2, 3},
                                                         {0, 1, 4, 5},
                                                         {0, 3, 4, 7},
                                                         {1, 2, 5, 6},
                                                         {2, 3, 6, 7},
                                                         {4, 5, 6, 7},
                                                         {0, 1, 2, 3, 4, 5, 6, 7}};
  const std::vector<std::vector<std::size_t>> of_wedge = {
      {0, 1}, {0, 2}, {0, 3}, {1, 2},       {1, 4},       {2, 5},
      {3, 4}, {3, 5}, {4, 5}, {0, 1, 3, 4}, {0, 2, 3, 5}, {1, 2, 4, 5}};
  const std::vector<std::vector<std::size_t>> of_pyramid = {
      {0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}, {0, 1, 2, 3}};
  const std::vector<Vec3d> wedge = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}},
                                    {{0, 0, 1}}, {{1, 0, 1}}, {{0, 1, 1}}};
  const std::vector<Vec3d> pyramid = {
      {{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}, {{.5, .5, 1}}};
  const auto first = [](const auto& all, std::size_t n) {
    return std::vector(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
  };
  return {{"tetrahedron",
           11,
           {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}},
           {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}},
           1.0 / 6},
          {"hexahedron of 20", 17, cube(), first(of_cube, 12), 1},
          {"hexahedron of 27", 12, cube(), of_cube, 1},
          {"wedge of 15", 18, wedge, first(of_wedge, 9), 0.5},
          {"wedge of 18", 13, wedge, of_wedge, 0.5},
          {"pyramid of 13", 19, pyramid, first(of_pyramid, 8), 1.0 / 3},
          {"pyramid of 14", 14, pyramid, of_pyramid, 1.0 / 3}};
}

std::string file_of(const GmshOrder& order) {
  std::vector<Vec3d> nodes = order.corners;
  for (const auto& corners : order.middles) {
    Vec3d p;
    for (const std::size_t corner : corners)
      p = p + order.corners[corner] * (1.0 / static_cast<double>(corners.size()));
    nodes.push_back(p);
  }
  std::string text =
      fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += fmt::format("{} {} {} {}\n", i + 1, nodes[i][0], nodes[i][1], nodes[i][2]);
  text += fmt::format("$EndNodes\n$Elements\n1\n1 {} 0", order.type);
  for (std::size_t i = 0; i < nodes.size(); ++i) text += fmt::format(" {}", i + 1);
  text += "\n$EndElements\n$NodeData\n1\n\"f\"\n1\n0\n3\n0\n1\n";
  text += fmt::format("{}\n", nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += fmt::format("{} {}\n", i + 1, nodes[i][0] + 2 * nodes[i][1] + 4 * nodes[i][2]);
  return text + "$EndNodeData\n";
}

/// Out of order, tetrahedra between all nodes would overlap.
TEST(msh_order, of_quadratic_elements_is_that_of_the_manual) {
  const TempDir directory;
  for (const GmshOrder& order : orders()) {
    SCOPED_TRACE(order.name);
    const TetrahedraOutcome outcome =
        test::tetrahedra_of(test::read_mesh(directory.write("x.msh", file_of(order))));
    for (std::size_t i = 0; i < outcome.mesh.tetrahedra.size(); ++i)
      EXPECT_GT(test::volume_of(outcome.mesh, i), 1e-3);
    EXPECT_NEAR(test::total_volume(outcome.mesh), order.volume, 1e-14);
    EXPECT_EQ(outcome.report.n_unused_points, 0U);
    EXPECT_EQ(outcome.report.n_left_handed, 0U);
    ASSERT_EQ(outcome.mesh.fields.size(), 1U);
    for (std::size_t i = 0; i < outcome.mesh.positions.size(); ++i) {
      const Vec3d& p = outcome.mesh.positions[i];
      EXPECT_NEAR(outcome.mesh.fields[0].values[i], p[0] + 2 * p[1] + 4 * p[2], 1e-14);
    }
  }
}

}  // namespace
}  // namespace lode::io
