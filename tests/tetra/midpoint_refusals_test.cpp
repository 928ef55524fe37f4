// Why vertices of a base of midpoints are still there.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>

#include "lode/models/tetra_mt/refusals.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/midpoint_checks.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Cut;
using oracles::noise_mesh;

std::uint64_t sum_of(const RefusalCounts& counts) {
  return std::accumulate(counts.counts.begin(), counts.counts.end(), std::uint64_t{0});
}

/// Vertices of the base's cells.
std::uint64_t n_base_vertices(const TetraMesh& mesh, const EdgeCollapses& collapses) {
  const Hierarchy hierarchy = hierarchy_of(mesh, collapses);
  std::set<std::uint32_t> there;
  for (const Tetrahedron& t : hierarchy.base) there.insert(t.begin(), t.end());
  there.erase(hierarchy.outside());
  return there.size();
}

/// Each vertex of the base is counted once.
RefusalCounts counted(const TetraMesh& mesh, std::uint64_t base_cells) {
  const EdgeCollapses collapses = collapsed(mesh, base_cells);
  EXPECT_EQ(sum_of(collapses.refusals), n_base_vertices(mesh, collapses));
  return collapses.refusals;
}

TetraMesh even_box() {
  TetraMesh box = noise_mesh(7, Cut::in_five, 1);
  std::ranges::fill(box.fields[0].values, 1);
  return box;
}

TEST(midpoint_refusals, are_corners_of_a_box) {
  const RefusalCounts counts = counted(even_box(), 0);
  EXPECT_EQ(counts[Refusal::boundary], 8U);
  EXPECT_EQ(counts[Refusal::extremum], 0U);
  EXPECT_EQ(counts[Refusal::non_manifold], 0U);
  EXPECT_EQ(counts[Refusal::regions], 0U);
}

TEST(midpoint_refusals, are_none_of_vertices_that_no_collapse_has_come_to) {
  const RefusalCounts counts = counted(noise_mesh(13, Cut::in_five, 3), 8000);
  EXPECT_GT(counts[Refusal::limit], sum_of(counts) / 2);
}

/// Along the edge that two blocks have in common: its vertices, but for its ends in corners.
TEST(midpoint_refusals, are_links_that_are_no_spheres) {
  TetraMesh edge = noise_mesh(9, Cut::in_six, 11);
  std::erase_if(edge.tetrahedra, [&](const Tetrahedron& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + edge.positions[v] * 0.25;
    return (centre[0] < 0.5) != (centre[1] < 0.5);
  });
  EXPECT_EQ(counted(edge, 0)[Refusal::non_manifold], 9U);
}

/// A cube round its centre. No corner has the diagonals of all three sides beside it: so the centre
/// goes to none of them without a flat tetrahedron.
TetraMesh cube_round_its_centre() {
  TetraMesh mesh;
  for (std::uint32_t v = 0; v < 8; ++v)
    mesh.positions.push_back(
        {{v % 2 == 0 ? 0.0 : 1.0, v / 2 % 2 == 0 ? 0.0 : 1.0, v < 4 ? 0.0 : 1.0}});
  mesh.positions.push_back({{0.5, 0.5, 0.5}});
  const std::array<std::array<std::uint32_t, 4>, 6> sides{
      {{0, 2, 6, 4}, {7, 3, 1, 5}, {0, 4, 5, 1}, {7, 6, 2, 3}, {1, 3, 2, 0}, {5, 4, 6, 7}}};
  for (const std::array<std::uint32_t, 4>& q : sides) {
    for (const auto& [a, b, c] : {std::array{q[0], q[1], q[2]}, std::array{q[0], q[2], q[3]}}) {
      Tetrahedron t{8, a, b, c};
      const auto way = [&](std::size_t k) { return mesh.positions[t[k]] - mesh.positions[8]; };
      if (dot(cross(way(1), way(2)), way(3)) < 0) std::swap(t[2], t[3]);
      mesh.tetrahedra.push_back(t);
    }
  }
  mesh.fields.push_back({.name = "f", .type = {}, .n_components = 1, .values = {}});
  mesh.fields[0].values.assign(9, 1);
  return mesh;
}

/// A maximum and a minimum go nowhere together, and one of either alone does no harm.
TEST(midpoint_refusals, are_extrema_of_both_kinds) {
  TetraMesh peak = noise_mesh(7, Cut::in_six, 1);
  std::ranges::fill(peak.fields[0].values, 0);
  peak.fields[0].values[(3 * 7 + 3) * 7 + 3] = 1;
  EXPECT_EQ(counted(peak, 0)[Refusal::extremum], 0U);
  TetraMesh cube = cube_round_its_centre();
  EXPECT_EQ(counted(cube, 0)[Refusal::shape], 9U);
  cube.fields[0].values[8] = 0;
  EXPECT_EQ(counted(cube, 0)[Refusal::shape], 9U);
  cube.fields[0].values[3] = 2;
  const RefusalCounts counts = counted(cube, 0);
  EXPECT_EQ(counts[Refusal::extremum], 1U);
  EXPECT_EQ(counts[Refusal::shape], 8U);
}

TEST(midpoint_refusals, are_regions_that_end_where_they_touch) {
  TetraMesh box = even_box();
  for (const Tetrahedron& t : box.tetrahedra) {
    bool is_first = true;
    bool is_last = true;
    for (const std::uint32_t v : t)
      for (const double c : box.positions[v].v) {
        is_first = is_first && c < 0.51;
        is_last = is_last && c > 0.49;
      }
    box.regions.push_back(is_first || is_last ? 1 : 0);
  }
  box.region_ids = {3, 4};
  EXPECT_GE(counted(box, 0)[Refusal::regions], 1U);
}

TEST(midpoint_refusals, are_counted_in_any_order_and_for_any_number_of_threads) {
  const TetraMesh mesh = noise_mesh(13, Cut::in_five, 3);
  for (const CollapseOrder order :
       {CollapseOrder::squared_error, CollapseOrder::space_error, CollapseOrder::quadric}) {
    std::array<RefusalCounts, 2> counts;
    for (int i = 0; i < 2; ++i) {
      Progress progress;
      const auto collapses =
          collapse_edges(mesh, {.base_cells = 0, .order = order, .threads = {1 + 2 * i}}, progress);
      ASSERT_TRUE(collapses);
      counts[static_cast<std::size_t>(i)] = collapses->refusals;
      EXPECT_EQ(sum_of(collapses->refusals), n_base_vertices(mesh, *collapses));
      // Hardly an edge is left that might go.
      EXPECT_LT(collapses->refusals[Refusal::limit], sum_of(collapses->refusals) / 4);
    }
    EXPECT_EQ(counts[0].counts, counts[1].counts);
  }
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
