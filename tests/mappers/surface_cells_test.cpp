// Which tetrahedra surfaces are made of.
#include "lode/mappers/surface_cells.h"

#include <algorithm>
#include <array>
#include <map>

#include "tests/mappers/tetra_fixtures.h"

namespace lode {
namespace {

using test::isosurface_of;
using test::noise;

std::size_t n_marked(const std::vector<std::uint8_t>& is_marked) {
  return static_cast<std::size_t>(std::ranges::count(is_marked, 1));
}

TEST(surface_cells, at_the_boundary_have_all_of_its_faces) {
  const SimplexMesh mesh = noise(6);
  std::map<std::array<std::uint32_t, 3>, int> n_cells;
  const auto visit_faces = [&](std::size_t cell, const auto& visit) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      auto face = face_across(mesh.tetrahedra[cell], corner);
      std::ranges::sort(face);
      visit(face);
    }
  };
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    visit_faces(i, [&](const auto& face) { ++n_cells[face]; });
  const std::vector<std::uint8_t> found = cells_at_boundary(mesh);
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    bool is_outer = false;
    visit_faces(i, [&](const auto& face) { is_outer = is_outer || n_cells[face] == 1; });
    EXPECT_EQ(found[i] != 0, is_outer) << i;
  }
  EXPECT_GT(n_marked(found), 100U);
  EXPECT_LT(n_marked(found), mesh.tetrahedra.size());
}

TEST(surface_cells, with_values_make_the_isosurface_and_no_others) {
  SimplexMesh mesh = noise(6);
  const Surface expected = isosurface_of(mesh, 0.31);
  const std::vector<std::uint8_t> found = cells_with_values(mesh, std::array{0.31});
  const std::size_t n = n_marked(found);
  EXPECT_LT(n, mesh.tetrahedra.size());
  keep_marked_cells(mesh, found);
  EXPECT_EQ(mesh.tetrahedra.size(), n);
  EXPECT_EQ(isosurface_of(mesh, 0.31).triangles.size(), expected.triangles.size());
  // Each makes at least a triangle.
  EXPECT_GE(expected.triangles.size(), n);
  EXPECT_EQ(n_marked(cells_with_values(mesh, std::array{1e9, -1e9})), 0U);
}

TEST(surface_cells, at_planes_are_those_on_both_sides_of_one) {
  const SimplexMesh mesh = noise(6);
  const std::array planes{SectionPlane{{{0.5, 0.5, 0.31}}, {{0, 0, 1}}},
                          SectionPlane{{{0.22, 0, 0}}, {{2, 0, 0}}}};
  const std::vector<std::uint8_t> found = cells_at_planes(mesh, planes);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto crosses = [&](std::size_t axis, double at) {
      const auto side = [&](std::uint32_t v) { return mesh.positions[v][axis] < at; };
      return !std::ranges::all_of(mesh.tetrahedra[i], side) &&
             !std::ranges::none_of(mesh.tetrahedra[i], side);
    };
    EXPECT_EQ(found[i] != 0, crosses(2, 0.31) || crosses(0, 0.22));
  }
}

TEST(surface_cells, that_are_kept_have_their_own_errors) {
  SimplexMesh mesh = noise(3);
  const std::size_t n = mesh.tetrahedra.size();
  mesh.errors.clear();
  Attribute attribute{"more", false, {}, 1e9};
  for (std::size_t i = 0; i < n; ++i) {
    mesh.errors.push_back(static_cast<float>(i));
    attribute.errors.push_back(static_cast<float>(2 * i));
  }
  mesh.attributes = {attribute, {"unknown", false, {}, 5}};
  std::vector<std::uint8_t> is_marked(n, 0);
  is_marked[2] = is_marked[5] = 1;
  const auto kept = mesh.tetrahedra[5];
  keep_marked_cells(mesh, is_marked);
  EXPECT_EQ(mesh.errors, (std::vector<float>{2, 5}));
  EXPECT_EQ(mesh.tetrahedra[1], kept);
  EXPECT_EQ(mesh.attributes[0].error, 10);
  EXPECT_EQ(mesh.attributes[1].error, 5);
}

}  // namespace
}  // namespace lode
