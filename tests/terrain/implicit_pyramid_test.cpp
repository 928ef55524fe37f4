#include <algorithm>
#include <cmath>
#include <set>

#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/models/terrain/implicit_pyramid/thinned_mesh.h"
#include "lode/models/terrain/implicit_pyramid/thinning.h"
#include "tests/terrain/insertions_fixtures.h"

namespace lode::implicit_pyramid {
namespace {

using delaunay::Tin;
using insertions::History;
using insertions::test::Case;
using insertions::test::cases;

Tin full_tin_of(const HeightGrid& grid) {
  auto full = delaunay::to_full_tin(grid);
  EXPECT_TRUE(full);
  return std::move(full->tin);
}

/// Corners of the outline, which stay.
std::vector<bool> outline_of(const HeightGrid& grid, const Tin& tin) {
  const auto domain = delaunay::find_domain(grid);
  EXPECT_TRUE(domain);
  const delaunay::LatticePacking packing(grid.n_columns);
  std::set<std::uint32_t> corners;
  for (const auto& triangle : domain->triangles) corners.insert(triangle.begin(), triangle.end());
  std::vector<bool> stays;
  for (const delaunay::LatticePoint& p : tin.vertices)
    stays.push_back(corners.contains(packing.pack(p)));
  return stays;
}

/// What is left of a mesh: slots that holes leave empty still have triangles of what is gone.
Tin left_of(const ThinnedMesh& mesh, const std::vector<bool>& is_gone) {
  Tin tin = mesh.tin();
  std::erase_if(tin.triangles, [&](const auto& corners) {
    return std::ranges::any_of(corners, [&](std::uint32_t v) { return is_gone[v]; });
  });
  tin.twins.clear();
  return tin;
}

Thinning thinning_of(const HeightGrid& grid) {
  Tin full = full_tin_of(grid);
  const std::vector<bool> stays = outline_of(grid, full);
  Progress progress;
  auto made = thin(std::move(full), stays, progress);
  EXPECT_TRUE(made);
  return *std::move(made);
}

TEST(implicit_pyramid, levels_are_maximal_independent_sets_of_few_neighbours) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Thinning thinning = thinning_of(c.grid);
    const Tin full = full_tin_of(c.grid);
    const std::vector<bool> stays = outline_of(c.grid, full);
    std::vector<bool> is_gone(full.vertices.size());
    ThinnedMesh mesh(full);
    for (const auto& level : thinning) {
      std::set<std::uint32_t> goes;
      for (const RemovedVertex& removed : level) goes.insert(removed.vertex);
      ASSERT_EQ(goes.size(), level.size());
      for (std::uint32_t v = 0; v < full.vertices.size(); ++v) {
        if (stays[v] || is_gone[v]) {
          EXPECT_FALSE(goes.contains(v)) << "must stay, or is gone";
          continue;
        }
        const std::vector<std::uint32_t> ring = mesh.neighbours(v);
        const bool has_neighbour =
            std::ranges::any_of(ring, [&](std::uint32_t u) { return goes.contains(u); });
        if (goes.contains(v)) EXPECT_FALSE(has_neighbour) << "two neighbours go";
        if (goes.contains(v)) EXPECT_LE(ring.size(), 2 * kMostNeighbours);
        if (ring.size() <= kMostNeighbours)
          EXPECT_TRUE(goes.contains(v) || has_neighbour) << "could go, too";
      }
      for (const RemovedVertex& removed : level) {
        const auto& ring = mesh.neighbours(removed.vertex);
        EXPECT_NE(std::ranges::find(ring, removed.neighbour), ring.end());
        mesh.remove(removed.vertex);
        is_gone[removed.vertex] = true;
      }
    }
    for (std::uint32_t v = 0; v < full.vertices.size(); ++v) EXPECT_EQ(is_gone[v], !stays[v]);
  }
}

TEST(implicit_pyramid, holes_are_filled_delaunay) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Thinning thinning = thinning_of(c.grid);
    const Tin full = full_tin_of(c.grid);
    ThinnedMesh mesh(full);
    std::vector<bool> is_gone(full.vertices.size());
    for (const auto& level : thinning) {
      for (const RemovedVertex& removed : level) {
        mesh.remove(removed.vertex);
        is_gone[removed.vertex] = true;
      }
      const Tin left = left_of(mesh, is_gone);
      delaunay::test::expect_fills(left, c.grid);
      delaunay::test::expect_locally_delaunay(left);
    }
  }
}

TEST(implicit_pyramid, has_all_samples_and_logarithmically_many_levels) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const History history =
        insertions::test::history_of(c.grid, 0, insertions::Model::implicit_delaunay_pyramid);
    EXPECT_EQ(history.vertices.size(), history.n_samples);
    EXPECT_EQ(history.max_error, 0);
    const double n = std::max(2.0, static_cast<double>(history.n_samples));
    EXPECT_LE(static_cast<double>(history.level_ends.size()), 1 + std::log(n) / std::log(18. / 17));
    for (std::uint32_t node = 0; node < history.n_nodes(); ++node)
      EXPECT_LE(history.removed_by(node).size(), 2 * kMostNeighbours);
    for (const std::uint32_t end : history.level_ends) {
      const Tin tin = tin_at(history, end, delaunay::TinLinks::kept);
      const double stated = *std::ranges::max_element(tin.errors);
      insertions::test::expect_true(tin, c.grid, stated);
      delaunay::test::expect_locally_delaunay(tin);
    }
  }
}

TEST(implicit_pyramid, is_true_at_any_tolerance) {
  for (const Case& c : cases()) {
    const History history =
        insertions::test::history_of(c.grid, 0, insertions::Model::implicit_delaunay_pyramid);
    for (const double tolerance : {1000.0, 123.0, 7.5, 0.0}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      const Tin tin =
          tin_of(history, nodes_within(history, tolerance), delaunay::TinLinks::left_out);
      insertions::test::expect_true(tin, c.grid, tolerance);
      delaunay::test::expect_locally_delaunay(tin);
    }
  }
}

}  // namespace
}  // namespace lode::implicit_pyramid
