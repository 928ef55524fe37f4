// Which regions vertices of midpoints meet, as cuts tell, held against the reference mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/midpoint/structure_check.h"
#include "lode/models/tetra_mt/random_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/tetra/midpoint_fixtures.h"
#include "tests/tetra/region_meshes.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// By node: the regions of the reference's tetrahedra round all leaves that come of it.
std::vector<std::uint64_t> masks_of_reference(const TetraMesh& mesh, const Hierarchy& hierarchy) {
  std::vector<std::uint64_t> round(hierarchy.n_labels(), 0);
  const TetraMesh by_labels = test::labelled(mesh, hierarchy);
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (const std::uint32_t leaf : by_labels.tetrahedra[i])
      round[leaf] |= std::uint64_t{1} << mesh.regions[i] % 64;
  std::vector<std::uint64_t> masks;
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node) {
    const auto [first, second] = hierarchy.children(node);
    masks.push_back(round[first] | round[second]);
    round[hierarchy.n_vertices + node] = masks.back();
  }
  return masks;
}

TEST(midpoint_regions, are_those_of_the_reference_in_any_cut) {
  std::uint64_t n_all = 0;
  for (const TetraMesh& mesh : test::meshes_of_regions()) {
    Hierarchy hierarchy = test::midpoints_of(mesh, 200);
    const auto masks = masks_of_reference(mesh, hierarchy);
    const std::uint32_t n_nodes = hierarchy.n_nodes();
    n_all += n_nodes;
    const Forest forest(std::move(hierarchy));
    for (const std::uint32_t n : {0U, n_nodes / 20, n_nodes}) {
      MidpointCut cut(forest);
      apply_at_random(n_nodes, n, 7, cut);
      for (std::uint32_t node = 0; node < n_nodes; ++node) {
        const std::uint64_t mask = cut.region_mask(NodeId{node});
        // Of what has not come yet it may be more.
        const std::uint32_t parent = forest.parent(node);
        const bool is_known = parent == kNone || cut.has_vertex(forest.head().n_vertices + node) ||
                              mask == masks[node];
        if (is_known)
          ASSERT_EQ(mask, masks[node]) << node;
        else
          ASSERT_EQ(mask & masks[node], masks[node]) << node;
      }
    }
    Progress progress;
    const auto findings = check_structure(forest, 1, progress);
    ASSERT_TRUE(findings);
    EXPECT_TRUE(findings->is_sound()) << findings->regions.first;
    EXPECT_EQ(findings->regions.n_checked, n_nodes);
  }
  EXPECT_GT(n_all, 2000U);
}

TEST(midpoint_regions, decide_what_is_refined) {
  for (const TetraMesh& mesh : test::meshes_of_regions()) {
    Hierarchy hierarchy = test::midpoints_of(mesh, 200);
    const auto masks = masks_of_reference(mesh, hierarchy);
    const Forest forest(std::move(hierarchy));
    for (const std::uint64_t wanted : {1U, 2U})
      for (const double tolerance : {0.1, 0.0}) {
        MidpointCut cut(forest);
        Engine<MidpointCut> engine(cut);
        engine.set_query(within_regions(uniform_demand(tolerance), wanted));
        engine.finish();
        // What is wanted, and what that waits for: nothing else.
        MidpointCut closed(forest);
        std::vector<bool> is_applied(masks.size(), false);
        std::size_t n_wanted = 0;
        for (std::uint32_t node = 0; node < masks.size(); ++node) {
          if ((masks[node] & wanted) == 0) continue;
          if (tolerance > 0 && static_cast<double>(cut.facts(NodeId{node}).error) <= tolerance)
            continue;
          ++n_wanted;
          apply_after_parents(NodeId{node}, closed, is_applied);
        }
        EXPECT_GT(n_wanted, 0U);
        EXPECT_EQ(engine.cut().n_applied(),
                  static_cast<std::size_t>(std::ranges::count(is_applied, true)));
        EXPECT_EQ(sorted_cells(cut.cells()), sorted_cells(closed.cells()));
        // From one region to the other, and back: the same as at once.
        MidpointCut other(forest);
        Engine<MidpointCut> moving(other);
        for (const std::uint64_t region : {std::uint64_t{3} - wanted, wanted}) {
          moving.set_query(within_regions(uniform_demand(tolerance), region));
          moving.finish();
        }
        EXPECT_EQ(sorted_cells(cut.cells()), sorted_cells(other.cells()));
      }
  }
}

TEST(midpoint_regions, marked_otherwise_are_found) {
  const TetraMesh mesh = test::meshes_of_regions().front();
  const Hierarchy hierarchy = test::midpoints_of(mesh, 200);
  ASSERT_FALSE(hierarchy.mixed_regions.empty());
  int n_found = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    Hierarchy changed = hierarchy;
    auto& mark = changed.base_regions[i * changed.base_regions.size() / 10];
    mark = 1 - std::min(mark, 1U);
    Progress progress;
    const auto findings = check_structure(Forest(std::move(changed)), 1, progress);
    ASSERT_TRUE(findings);
    n_found += findings->is_sound() ? 0 : 1;
  }
  EXPECT_GT(n_found, 0);
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
