// Which regions nodes of half edges meet: held against the reference mesh, through pages and files.

#include "lode/models/tetra_mt/region_masks.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/models/tetra_mt/structure_check.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/tetra/file_fixtures.h"
#include "tests/tetra/region_meshes.h"

namespace lode::tetra_mt {
namespace {

std::vector<std::byte> links_of(const PageContent& content, std::uint32_t page,
                                const PageShape& shape) {
  LinkModels models{};
  return encode_links(content, page, shape, models);
}

using oracles::Random;
using test::meshes_of_regions;
using test::random_regions;

/// By node: the regions of the reference's tetrahedra round its vertex, and round those of all that
/// it discovers.
std::vector<std::uint64_t> masks_of_reference(const TetraMesh& mesh, const Hierarchy& hierarchy) {
  std::vector<std::uint64_t> round(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (const std::uint32_t v : mesh.tetrahedra[i])
      round[v] |= std::uint64_t{1} << mesh.regions[i] % 64;
  std::vector<std::uint64_t> masks;
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node)
    masks.push_back(round[hierarchy.mesh_vertices[hierarchy.n_base_vertices + node]]);
  for (auto at = hierarchy.order.rbegin(); at != hierarchy.order.rend(); ++at)
    if (hierarchy.discoverers[*at] != kNone) masks[hierarchy.discoverers[*at]] |= masks[*at];
  return masks;
}

TEST(region_masks, are_those_of_the_reference_round_all_that_is_discovered) {
  for (const TetraMesh& mesh : meshes_of_regions()) {
    const Hierarchy hierarchy = test::hierarchy_of(mesh, 200);
    EXPECT_EQ(hierarchy.region_masks, masks_of_reference(mesh, hierarchy));
    const auto packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), {2});
    for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node)
      ASSERT_EQ(packed.region_mask(node), hierarchy.region_masks[node]);
  }
}

TEST(region_masks, come_back_from_bytes_and_are_none_of_one_region) {
  for (const TetraMesh& mesh : meshes_of_regions()) {
    const Hierarchy hierarchy = test::hierarchy_of(mesh, 200);
    const HierarchyHead head = head_of(hierarchy, mesh.tetrahedra.size());
    for (std::uint32_t page = 0; page < head.shape.n_pages(); ++page) {
      const PageContent content = content_of(hierarchy, page);
      PageContent found;
      const auto bytes = links_of(content, page, head.shape);
      LinkModels models{};
      ASSERT_TRUE(decode_links(bytes, "page", page, head.shape, models, found));
      EXPECT_EQ(found, content);
    }
  }
  TetraMesh mesh = random_regions(12, 1, 4, 5);
  const Hierarchy one = test::hierarchy_of(mesh, 200);
  EXPECT_TRUE(one.region_masks.empty());
  const HierarchyHead head = head_of(one, mesh.tetrahedra.size());
  PageContent content = content_of(one, 0);
  const NodePage page(content, 0, head.shape);
  EXPECT_EQ(page.region_mask(3), kAllRegions);
  // A page of one mask has that once.
  PageShape two = head.shape;
  two.n_regions = 2;
  content.region_masks.assign(content.n_nodes(), 2);
  EXPECT_LE(links_of(content, 0, two).size(),
            links_of(content_of(one, 0), 0, head.shape).size() + 3);
  EXPECT_EQ(NodePage(content, 0, two).n_bytes(), page.n_bytes() + sizeof(std::uint64_t));
  EXPECT_EQ(NodePage(content, 0, two).region_mask(3), 2U);
}

TEST(region_masks, of_other_bytes_are_of_the_regions_or_refused) {
  const TetraMesh mesh = random_regions(12, 5, 4, 2);
  const Hierarchy hierarchy = test::hierarchy_of(mesh, 200);
  const PageShape shape = head_of(hierarchy, 1).shape;
  const auto links = links_of(content_of(hierarchy, 1), 1, shape);
  Random random(1);
  int n_refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    auto bytes = links;
    // Masks are last.
    const std::size_t at =
        bytes.size() - 1 - random.below(bytes.size() / (trial % 2 == 0 ? 1 : 40));
    bytes[at] ^= static_cast<std::byte>(1 + random.below(255));
    PageContent found;
    LinkModels models{};
    if (!decode_links(bytes, "page", 1, shape, models, found)) {
      ++n_refused;
      continue;
    }
    for (const std::uint64_t mask : found.region_masks) EXPECT_TRUE(mask > 0 && mask < 32) << mask;
    static_cast<void>(NodePage(found, 1, shape).n_bytes());
  }
  EXPECT_GT(n_refused, 300);
}

StructureFindings check(const Hierarchy& hierarchy, const TetraMesh& mesh) {
  Progress progress;
  const auto packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), {2});
  const auto findings = check_structure(packed, 1, progress);
  EXPECT_TRUE(findings);
  return *findings;
}

TEST(region_masks, that_are_others_are_found) {
  const TetraMesh mesh = random_regions(12, 3, 4, 4);
  const Hierarchy hierarchy = test::hierarchy_of(mesh, 200);
  const StructureFindings right = check(hierarchy, mesh);
  EXPECT_TRUE(right.is_sound()) << right.regions.first;
  EXPECT_EQ(right.regions.n_checked, hierarchy.n_nodes());
  Random random(2);
  int n_changed = 0;
  while (n_changed < 30) {
    Hierarchy changed = hierarchy;
    const std::size_t node = random.below(changed.n_nodes());
    const std::uint64_t bit = std::uint64_t{1} << random.below(3);
    // One that is too many, or missing; not all.
    if ((changed.region_masks[node] ^= bit) == 0) continue;
    ++n_changed;
    const StructureFindings findings = check(changed, mesh);
    EXPECT_FALSE(findings.is_sound());
    EXPECT_GT(findings.regions.n_wrong, 0U);
    EXPECT_LE(findings.regions.n_wrong, 2U);  // it, and what discovers it
    EXPECT_EQ(findings.nesting.n_wrong + findings.refinement.n_wrong, 0U);
  }
}

/// Nodes that are wanted, and all that these depend on.
std::vector<NodeId> closure_of(const Hierarchy& hierarchy, std::uint64_t wanted, float tolerance) {
  std::vector<bool> is_in(hierarchy.n_nodes(), false);
  const auto packed = PackedHierarchy::pack(hierarchy, 1, {2});
  for (auto at = hierarchy.order.rbegin(); at != hierarchy.order.rend(); ++at) {
    const StoredFacts facts = packed.facts(*at, 0);
    const bool is_wanted =
        (hierarchy.region_masks[*at] & wanted) != 0 && (facts.error > tolerance || tolerance == 0);
    if (!is_wanted && !is_in[*at]) continue;
    is_in[*at] = true;
    for (const std::uint32_t parent : hierarchy.parents_of(*at)) is_in[parent] = true;
  }
  std::vector<NodeId> nodes;
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node)
    if (is_in[node]) nodes.push_back(NodeId{node});
  return nodes;
}

TEST(region_masks, decide_what_is_refined_in_memory_and_from_files) {
  const std::string path = fmt::format("{}lode_masks_{}.lode", testing::TempDir(), getpid());
  for (const TetraMesh& mesh : meshes_of_regions()) {
    const Hierarchy hierarchy = test::hierarchy_of(mesh, 200);
    Progress progress;
    ASSERT_TRUE(
        save(hierarchy, mesh.tetrahedra.size(), test::codes_of(hierarchy), path, {2}, progress));
    const auto opened = open(path);
    ASSERT_TRUE(opened) << opened.error().message;
    const auto memory = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), {2});
    for (const std::uint64_t wanted : {1U, 2U, 3U})
      for (const float tolerance : {0.2F, 0.05F, 0.0F}) {
        const Demand demand =
            within_regions(uniform_demand(static_cast<double>(tolerance)), wanted);
        const auto expected = closure_of(hierarchy, wanted, tolerance);
        for (const auto* const packed : {&memory, &opened->hierarchy}) {
          TetraCut cut(*packed);
          Engine<TetraCut> engine(cut);
          engine.set_query(demand);
          engine.finish();
          auto applied = engine.cut().applied();
          std::ranges::sort(applied);
          EXPECT_EQ(applied, expected);
          EXPECT_TRUE(cut.check());
        }
      }
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace lode::tetra_mt
