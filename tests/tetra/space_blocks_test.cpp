// How a mesh is closed, and cut in blocks to collapse side by side.
#include "lode/models/tetra_mt/space_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::tetra_mt {
namespace {

using oracles::Random;

/// Some vertices are not asked for, and some tetrahedra gone; those to the outside have a number
/// above all.
struct CutCase {
  TetraMesh mesh;
  std::vector<Tetrahedron> tetrahedra;
  std::vector<std::uint32_t> there;

  explicit CutCase(std::uint32_t side) : mesh(oracles::noise_mesh(side, oracles::Cut::in_five, 3)) {
    tetrahedra = mesh.tetrahedra;
    const auto n = static_cast<std::uint32_t>(mesh.positions.size());
    EXPECT_TRUE(close_boundary(n, tetrahedra, {2}));
    Random random(side);
    for (std::uint32_t v = 0; v < n; ++v)
      if (random.below(3) > 0) there.push_back(v);
    for (Tetrahedron& t : tetrahedra)
      if (random.below(5) == 0) t[0] = kNone;
  }
};

void expect_blocks(const CutCase& of, const MeshBlocks& blocks, std::size_t max_size) {
  std::vector<std::uint32_t> all;
  std::vector<std::uint32_t> block_of(of.mesh.positions.size() + 1, kNone);
  for (std::uint32_t b = 0; b < blocks.size(); ++b) {
    const auto vertices = blocks.vertices.of(b);
    EXPECT_FALSE(vertices.empty());
    EXPECT_LE(vertices.size(), max_size);
    EXPECT_TRUE(std::ranges::is_sorted(vertices));
    all.insert(all.end(), vertices.begin(), vertices.end());
    for (const std::uint32_t v : vertices) block_of[v] = b;
  }
  std::ranges::sort(all);
  EXPECT_EQ(all, of.there);
  EXPECT_EQ(blocks.block_of, block_of);
  std::vector<std::vector<std::uint32_t>> slots(blocks.size());
  for (std::uint32_t slot = 0; slot < of.tetrahedra.size(); ++slot) {
    if (of.tetrahedra[slot][0] == kNone) continue;
    std::set<std::uint32_t> beside;
    for (const std::uint32_t v : of.tetrahedra[slot])
      if (block_of[v] != kNone) beside.insert(block_of[v]);
    for (const std::uint32_t b : beside) slots[b].push_back(slot);
  }
  EXPECT_EQ(blocks.slots, slots);
}

TEST(mesh_blocks, have_each_vertex_once_and_all_tetrahedra_round_it) {
  for (const std::uint32_t side : {2U, 9U, 31U}) {  // of several parts, the last
    const CutCase of(side);
    for (const double share : {0.5, 0.38}) {
      const std::size_t max_size = side == 31 ? 1000 : 20;
      const MeshBlocks blocks =
          cut_mesh(of.mesh.positions, of.there, of.tetrahedra, max_size, share, {2});
      expect_blocks(of, blocks, max_size);
      const MeshBlocks again =
          cut_mesh(of.mesh.positions, of.there, of.tetrahedra, max_size, share, {1});
      EXPECT_EQ(again.vertices.points, blocks.vertices.points);
      EXPECT_EQ(again.vertices.begins, blocks.vertices.begins);
      EXPECT_EQ(again.slots, blocks.slots);
    }
  }
}

TEST(mesh_blocks, of_no_vertices_are_none) {
  const CutCase of(3);
  const MeshBlocks blocks = cut_mesh(of.mesh.positions, {}, of.tetrahedra, 10, 0.5, {2});
  EXPECT_EQ(blocks.size(), 0U);
  EXPECT_TRUE(blocks.slots.empty());
}

/// Of vertices that do not lie apart in any direction.
TEST(mesh_blocks, are_cut_where_all_points_are_one) {
  std::vector<std::uint32_t> points;
  for (std::uint32_t v = 0; v < 100; ++v) points.push_back(v);
  const SpaceBlocks blocks = cut_in_blocks(std::vector<Vec3d>(100), points, 7, 0.38, {2});
  std::vector<std::uint32_t> all(blocks.points);
  std::ranges::sort(all);
  EXPECT_EQ(all, points);
  for (std::size_t b = 0; b < blocks.size(); ++b) EXPECT_LE(blocks.of(b).size(), 7U);
}

using FaceSet = std::map<std::array<std::uint32_t, 3>, int>;

FaceSet faces_of_all(const std::vector<Tetrahedron>& tetrahedra) {
  FaceSet faces;
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t k = 0; k < 4; ++k) {
      auto face = others(t, k);
      std::ranges::sort(face);
      ++faces[face];
    }
  return faces;
}

TEST(closed_mesh, has_a_tetrahedron_on_each_face_of_one_turned_as_its_neighbour_is) {
  const TetraMesh mesh = oracles::noise_mesh(20, oracles::Cut::in_six, 4);
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  std::vector<Tetrahedron> closed = mesh.tetrahedra;
  ASSERT_TRUE(close_boundary(n, closed, {2}));
  std::vector<Tetrahedron> again = mesh.tetrahedra;
  ASSERT_TRUE(close_boundary(n, again, {1}));
  EXPECT_EQ(again, closed);
  std::size_t n_single = 0;
  for (const auto& [face, count] : faces_of_all(mesh.tetrahedra)) n_single += count == 1 ? 1 : 0;
  EXPECT_EQ(closed.size() - mesh.tetrahedra.size(), n_single);
  for (const auto& [face, count] : faces_of_all(closed)) ASSERT_EQ(count, 2);
  const auto across = find_across(closed);
  for (std::uint32_t i = 0; i < closed.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t other = across[i][k];
      ASSERT_NE(other, kNone);
      const auto place =
          static_cast<std::size_t>(std::ranges::find(across[other], i) - across[other].begin());
      ASSERT_LT(place, 4U);
      // The same face, seen from the other side: an odd permutation.
      const auto here = others(closed[i], k);
      const auto there = others(closed[other], place);
      const auto turned = std::ranges::find(there, here[0]) - there.begin();
      ASSERT_LT(turned, 3);
      EXPECT_EQ(there[static_cast<std::size_t>((turned + 1) % 3)], here[2]);
      EXPECT_EQ(there[static_cast<std::size_t>((turned + 2) % 3)], here[1]);
    }
}

TEST(closed_mesh, is_none_where_three_tetrahedra_have_a_face) {
  std::vector<Tetrahedron> tetrahedra{{0, 1, 2, 3}, {0, 2, 1, 4}, {1, 0, 2, 5}};
  const auto closed = close_boundary(6, tetrahedra, {2});
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().message,
            "expected faces of one or two tetrahedra, got one of 3: corners 0, 1 and 2");
}

}  // namespace
}  // namespace lode::tetra_mt
