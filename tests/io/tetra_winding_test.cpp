#include "lode/io/tetra_winding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "tests/io/tetra_checks.h"
#include "tests/oracles/random.h"

namespace lode::io {
namespace {

using test::tetrahedra_of;
using Corners = std::vector<std::uint32_t>;

struct WoundCell {
  CellType type = CellType::hexahedron;
  Corners corners;  ///< Of a polyhedron those of the hexahedron that it is.
  bool is_reversed = false;
};

/// Points of cubes [0, n]^3, and cells, which are read in the order they have here.
struct WoundMesh {
  int n = 1;
  std::vector<Vec3d> points;
  std::vector<WoundCell> cells;
};

WoundMesh grid_points(int nx, int ny, int nz) {
  WoundMesh mesh{.n = std::max({nx, ny, nz}), .points = {}, .cells = {}};
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) mesh.points.push_back({{1.0 * x, 1.0 * y, 1.0 * z}});
  return mesh;
}

Corners cube_at(int nx, int ny, int x, int y, int z) {
  const auto id = [&](int dx, int dy, int dz) {
    return static_cast<std::uint32_t>(((z + dz) * (ny + 1) + y + dy) * (nx + 1) + x + dx);
  };
  return {id(0, 0, 0), id(1, 0, 0), id(1, 1, 0), id(0, 1, 0),
          id(0, 0, 1), id(1, 0, 1), id(1, 1, 1), id(0, 1, 1)};
}

std::vector<Corners> faces_of_cube(const Corners& c) {
  return {{c[0], c[4], c[7], c[3]}, {c[1], c[2], c[6], c[5]}, {c[0], c[1], c[5], c[4]},
          {c[3], c[7], c[6], c[2]}, {c[0], c[3], c[2], c[1]}, {c[4], c[5], c[6], c[7]}};
}

/// The first and second of two equal halves change places, which is its mirror image.
Corners reversed(Corners corners) {
  const auto half = static_cast<std::ptrdiff_t>(corners.size() / 2);
  std::rotate(corners.begin(), corners.begin() + half, corners.end());
  return corners;
}

CellMesh to_cells(const WoundMesh& from, bool is_backwards = false) {
  CellMesh mesh = test::empty_cells();
  mesh.points = from.points;
  std::vector<WoundCell> cells = from.cells;
  if (is_backwards) std::ranges::reverse(cells);
  for (const WoundCell& cell : cells) {
    if (cell.type == CellType::polyhedron)
      test::add_polyhedron(mesh, faces_of_cube(cell.corners));
    else
      test::add_cell(mesh, cell.type, cell.is_reversed ? reversed(cell.corners) : cell.corners);
  }
  return mesh;
}

/// How many tetrahedra those cells alone become that are reversed.
std::uint64_t n_reversed_tetrahedra(const WoundMesh& mesh) {
  WoundMesh only{.n = mesh.n, .points = mesh.points, .cells = {}};
  std::ranges::copy_if(mesh.cells, std::back_inserter(only.cells), &WoundCell::is_reversed);
  return only.cells.empty() ? 0 : tetrahedra_of(to_cells(only)).mesh.tetrahedra.size();
}

/// Each face of two tetrahedra is seen from its two sides.
void expect_wound_alike(const TetraMesh& mesh) {
  std::map<test::FaceKey, std::vector<bool>> seen;
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      test::FaceKey face{};
      for (std::size_t i = 0, to = 0; i < 4; ++i)
        if (i != corner) face[to++] = t[i];
      int n_swaps = 0;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = i + 1; k < 3; ++k) n_swaps += face[i] > face[k] ? 1 : 0;
      std::ranges::sort(face);
      seen[face].push_back((n_swaps + static_cast<int>(corner)) % 2 != 0);
    }
  for (const auto& [face, sides] : seen) {
    ASSERT_LE(sides.size(), 2U);
    if (sides.size() == 2) ASSERT_NE(sides[0], sides[1]) << face[0] << ' ' << face[1];
  }
}

/// All is of positive volume, and that of `mesh` as turned.
void expect_turned(const WoundMesh& mesh, double volume) {
  for (const bool is_backwards : {false, true}) {
    const TetrahedraOutcome outcome = tetrahedra_of(to_cells(mesh, is_backwards));
    expect_wound_alike(outcome.mesh);
    EXPECT_EQ(outcome.report.n_inverted, 0U);
    EXPECT_EQ(outcome.report.n_zero_volume, 0U);
    EXPECT_EQ(outcome.report.n_components, 1U);
    EXPECT_EQ(outcome.report.n_left_handed + outcome.report.n_turned_wedges,
              n_reversed_tetrahedra(mesh));
    for (std::size_t i = 0; i < outcome.mesh.tetrahedra.size(); ++i)
      ASSERT_GT(test::volume_of(outcome.mesh, i), 0);
    EXPECT_NEAR(test::total_volume(outcome.mesh), volume, 1e-12 * volume);
  }
}

TEST(winding, of_cells_beside_a_polyhedron_is_put_right) {
  WoundMesh mesh = grid_points(2, 1, 1);
  const Corners c = cube_at(2, 1, 1, 0, 0);
  mesh.cells = {{CellType::polyhedron, cube_at(2, 1, 0, 0, 0)},
                {CellType::wedge, {c[0], c[1], c[2], c[4], c[5], c[6]}, false},
                {CellType::wedge, {c[0], c[2], c[3], c[4], c[6], c[7]}, true}};
  expect_turned(mesh, 2);
  mesh.cells = {{CellType::polyhedron, cube_at(2, 1, 0, 0, 0)}, {CellType::hexahedron, c, true}};
  expect_turned(mesh, 2);
}

/// Cubes as any kind of cell, columns as two wedges each; about a third is reversed.
WoundMesh mixed_cubes(int n, std::uint64_t seed, const std::vector<CellType>& types) {
  WoundMesh mesh = grid_points(n, n, n);
  oracles::Random random(seed);
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const Corners c = cube_at(n, n, x, y, z);
        const CellType type = types[random.below(types.size())];
        const auto is_reversed = [&] { return random.below(3) == 0; };
        // Those on the diagonal are all of one kind, so that it is there.
        if (x == y && y == z) {
          mesh.cells.push_back({CellType::polyhedron, c});
        } else if (type == CellType::wedge) {
          mesh.cells.push_back({type, {c[0], c[1], c[2], c[4], c[5], c[6]}, is_reversed()});
          mesh.cells.push_back({type, {c[0], c[2], c[3], c[4], c[6], c[7]}, is_reversed()});
        } else if (type == CellType::voxel) {
          mesh.cells.push_back(
              {type, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]}, is_reversed()});
        } else {
          mesh.cells.push_back({type, c, type != CellType::polyhedron && is_reversed()});
        }
      }
  return mesh;
}

class winding_of_mixtures : public testing::TestWithParam<std::uint64_t> {};

TEST_P(winding_of_mixtures, is_put_right_with_polyhedra_among_them) {
  using enum CellType;
  expect_turned(mixed_cubes(3, GetParam(), {hexahedron}), 27);
  expect_turned(mixed_cubes(3, GetParam(), {hexahedron, voxel, polyhedron}), 27);
}

INSTANTIATE_TEST_SUITE_P(seeds, winding_of_mixtures,
                         testing::Range(std::uint64_t{1}, std::uint64_t{9}));

/// Cubes in a row, and one that hangs on the first by a face but lies inside of it.
WoundMesh folded_row(CellType row, CellType folded) {
  WoundMesh mesh = grid_points(4, 1, 1);
  for (int x = 0; x < 4; ++x) mesh.cells.push_back({row, cube_at(4, 1, x, 0, 0)});
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (const auto& [y, z] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    mesh.points.push_back({{0.5, 1.0 * y, 1.0 * z}});
  const Corners c = cube_at(4, 1, 0, 0, 0);
  mesh.cells.push_back({folded, {first, c[0], c[3], first + 1, first + 3, c[4], c[7], first + 2}});
  return mesh;
}

TEST(winding, of_a_polyhedron_folded_over_others_counts_it_as_inverted) {
  using enum CellType;
  for (const CellType folded : {polyhedron, hexahedron})
    for (const CellType row : {polyhedron, hexahedron})
      for (const bool is_reversed : {false, true}) {
        WoundMesh mesh = folded_row(row, folded);
        // Some of the others are listed the other way.
        if (row == hexahedron) mesh.cells[2].is_reversed = is_reversed;
        for (const bool is_backwards : {false, true}) {
          const TetrahedraOutcome outcome = tetrahedra_of(to_cells(mesh, is_backwards));
          expect_wound_alike(outcome.mesh);
          std::uint64_t n_negative = 0;
          double negative = 0;
          for (std::size_t i = 0; i < outcome.mesh.tetrahedra.size(); ++i)
            if (test::volume_of(outcome.mesh, i) < 0) {
              ++n_negative;
              negative += test::volume_of(outcome.mesh, i);
            }
          EXPECT_NEAR(negative, -0.5, 1e-12);
          EXPECT_NEAR(test::total_volume(outcome.mesh), 3.5, 1e-12);
          EXPECT_EQ(outcome.report.n_inverted, n_negative);
          if (folded == polyhedron) EXPECT_EQ(n_negative, 12U);
          EXPECT_EQ(outcome.report.n_left_handed, n_reversed_tetrahedra(mesh));
        }
      }
}

/// A ring of cubes whose last one meets the first as its mirror image: it cannot be wound alike.
WoundMesh twisted_ring(bool is_reversed) {
  constexpr std::array<std::array<double, 2>, 4> kAround = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  WoundMesh mesh;
  for (const auto& [x, y] : kAround)
    for (const auto& [r, z] : {std::pair{2.0, 0.0}, {3.0, 0.0}, {3.0, 1.0}, {2.0, 1.0}})
      mesh.points.push_back({{r * x, r * y, z}});
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t a = 4 * i;
    const std::uint32_t b = 4 * ((i + 1) % 4);
    const Corners far = i == 3 ? Corners{b + 1, b, b + 3, b + 2} : Corners{b, b + 1, b + 2, b + 3};
    const bool is_polyhedron = i == 1;
    mesh.cells.push_back({is_polyhedron ? CellType::polyhedron : CellType::hexahedron,
                          {far[0], far[1], far[2], far[3], a, a + 1, a + 2, a + 3},
                          is_reversed && !is_polyhedron});
  }
  return mesh;
}

TEST(winding, of_what_cannot_be_wound_alike_is_that_of_most_and_polyhedra_stay) {
  const TetrahedraOutcome plain = tetrahedra_of(to_cells(twisted_ring(false)));
  const TetrahedraOutcome turned = tetrahedra_of(to_cells(twisted_ring(true)));
  const std::size_t n = plain.mesh.tetrahedra.size();
  ASSERT_EQ(turned.mesh.tetrahedra.size(), n);
  EXPECT_EQ(plain.report.n_components, 1U);
  // All turn but the polyhedron's 12, in one of the two.
  EXPECT_EQ(plain.report.n_left_handed + turned.report.n_left_handed, n - 12);
  EXPECT_TRUE(plain.report.n_left_handed == 0 || turned.report.n_left_handed == 0);
  EXPECT_EQ(plain.report.n_inverted, turned.report.n_inverted);
  for (const TetrahedraOutcome& outcome : {plain, turned}) {
    const auto centre = static_cast<std::uint32_t>(outcome.mesh.positions.size() - 1);
    for (std::size_t i = 0; i < n; ++i)
      if (std::ranges::count(outcome.mesh.tetrahedra[i], centre) > 0)
        EXPECT_GT(test::volume_of(outcome.mesh, i), 0);
  }
}

}  // namespace
}  // namespace lode::io
