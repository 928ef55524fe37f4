// What files say, with the base, of the nodes that it waits for.

#include "lode/models/tetra_mt/front_nodes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/file_fixtures.h"
#include "tests/tetra/region_meshes.h"

namespace lode::tetra_mt {
namespace {

using test::codes_of;
using test::noise;

Hierarchy hierarchy_with_world_errors(const TetraMesh& mesh, std::uint64_t base_cells) {
  Progress progress;
  const auto collapses = collapse_half_edges(
      mesh, {.base_cells = base_cells, .rules = {.has_world_errors = true}, .threads = {2}},
      progress);
  EXPECT_TRUE(collapses);
  auto hierarchy = make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy);
  return std::move(*hierarchy);
}

class front_nodes : public testing::Test {
 protected:
  void write(const TetraMesh& mesh, std::uint64_t base_cells) {
    hierarchy_ = hierarchy_with_world_errors(mesh, base_cells);
    Progress progress;
    ASSERT_TRUE(
        save(hierarchy_, mesh.tetrahedra.size(), codes_of(hierarchy_), path_, {2}, progress));
  }
  ~front_nodes() override {
    for (const char* const end : {"", ".lying.lode"}) std::filesystem::remove(path_ + end);
  }

  std::string path_ = fmt::format("{}lode_front_{}.lode", testing::TempDir(), getpid());
  Hierarchy hierarchy_;
};

void expect_same(const PackedHierarchy& a, const PackedHierarchy& b, std::uint32_t node,
                 std::size_t n_fields) {
  EXPECT_EQ(a.bounds(node), b.bounds(node));
  EXPECT_EQ(a.region_mask(node), b.region_mask(node));
  for (std::size_t f = 0; f < n_fields; ++f) {
    EXPECT_EQ(a.facts(node, f).error, b.facts(node, f).error);
    EXPECT_EQ(a.facts(node, f).low, b.facts(node, f).low);
    EXPECT_EQ(a.facts(node, f).high, b.facts(node, f).high);
    EXPECT_EQ(a.world_error(node, f), b.world_error(node, f));
  }
}

TEST_F(front_nodes, are_known_as_pages_say_and_no_page_is_read_for_them) {
  TetraMesh two_fields = noise();
  two_fields.fields.push_back(two_fields.fields[0]);
  for (double& v : two_fields.fields.back().values) v = 1e30 * v * v - 3;
  for (const TetraMesh& mesh :
       {two_fields, test::random_regions(12, 5, 4, 2), test::random_regions(10, 90, 2, 3)}) {
    write(mesh, 200);
    const auto memory = PackedHierarchy::pack(hierarchy_, mesh.tetrahedra.size(), {2});
    auto opened = open(path_);
    ASSERT_TRUE(opened) << opened.error().message;
    std::set<std::uint32_t> waited_for(hierarchy_.base_makers.begin(),
                                       hierarchy_.base_makers.end());
    waited_for.erase(kNone);
    ASSERT_FALSE(waited_for.empty());
    const std::size_t n_fields = mesh.fields.size();
    for (const std::uint32_t node : waited_for) {
      ASSERT_TRUE(opened->hierarchy.head().front->find(node));
      expect_same(opened->hierarchy, memory, node, n_fields);
      EXPECT_TRUE(opened->hierarchy.has_facts(node, 0));
    }
    EXPECT_EQ(opened->hierarchy.n_pages_loaded(), 0U);
    EXPECT_EQ(opened->hierarchy.n_field_pages_loaded(0), 0U);
    // Others come with their pages, and then those too.
    for (std::uint32_t node = 0; node < hierarchy_.n_nodes(); ++node) {
      EXPECT_EQ(opened->hierarchy.head().front->find(node).has_value(), waited_for.contains(node));
      static_cast<void>(opened->hierarchy.links(node));
      static_cast<void>(opened->hierarchy.value(hierarchy_.n_base_vertices + node, 0));
      expect_same(opened->hierarchy, memory, node, n_fields);
    }
    EXPECT_EQ(opened->hierarchy.n_pages_loaded(), opened->hierarchy.head().shape.n_pages());
    EXPECT_TRUE(opened->hierarchy.check());
  }
}

TEST_F(front_nodes, let_the_base_answer_without_pages) {
  write(noise(), 300);
  auto opened = open(path_);
  TetraCut cut(opened->hierarchy);
  Engine<TetraCut> engine(cut);
  const double base_error = opened->hierarchy.head().fields[0].base_error;
  engine.set_query(uniform_demand(1.01 * base_error));
  engine.finish();
  EXPECT_TRUE(engine.cut().applied().empty());
  EXPECT_EQ(opened->hierarchy.n_pages_loaded(), 0U);
  engine.set_query(uniform_demand(0.9 * base_error));
  engine.finish();
  EXPECT_FALSE(engine.cut().applied().empty());
  EXPECT_GT(opened->hierarchy.n_pages_loaded(), 0U);
  EXPECT_LT(opened->hierarchy.n_pages_loaded(), opened->hierarchy.head().shape.n_pages());
}

/// A block in place of one of a file's.
void replace(const std::string& from, const std::string& to, const store::BlockKey& key,
             const std::vector<std::byte>& bytes) {
  const auto reader = store::Reader::open(from);
  ASSERT_TRUE(reader);
  auto writer = store::Writer::create(to, reader->model(),
                                      {reader->metadata().begin(), reader->metadata().end()});
  ASSERT_TRUE(writer);
  for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
    const auto old = reader->read_block(i);
    ASSERT_TRUE(old);
    const auto& chosen = reader->blocks()[i].key == key ? bytes : *old;
    ASSERT_TRUE(writer->append(reader->blocks()[i].key,
                               store::encode_block_as(store::Codec::none, {.raw = chosen})));
  }
  ASSERT_TRUE(writer->finish());
}

TEST_F(front_nodes, of_which_pages_say_something_else_are_refused) {
  write(test::random_regions(12, 5, 4, 2), 200);
  HierarchyHead head = head_of(hierarchy_, 1);
  FrontNodes front = front_of(hierarchy_, head);
  const NumberedField field = field_of(hierarchy_, 0);
  const FieldBase base = base_of(field, head.shape);
  FrontFacts facts =
      front_facts_of(field, base.scale, WorldCodes(head.lower, head.upper), front.nodes);
  const std::string lying = path_ + ".lying.lode";
  const std::uint32_t node = front.nodes[front.nodes.size() / 2];
  const std::size_t place = front.nodes.size() / 2;
  const auto expect_refused = [&](const store::BlockKey& key, const std::vector<std::byte>& bytes) {
    replace(path_, lying, key, bytes);
    const auto opened = open(lying);
    ASSERT_TRUE(opened) << opened.error().message;
    static_cast<void>(opened->hierarchy.links(node));
    static_cast<void>(opened->hierarchy.value(hierarchy_.n_base_vertices + node, 0));
    static_cast<void>(
        opened->hierarchy.world_error(node % kPageNodes == 0 ? node + 1 : node - 1, 0));
    const auto found = opened->hierarchy.check();
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().message.find(
                  fmt::format("node {}: expected what is said of it with the base", node)),
              std::string::npos)
        << found.error().message;
    EXPECT_NE(found.error().message.find(lying), std::string::npos);
  };
  const FrontBase tetrahedra = front_base_of(head);
  const BoxCodes codes(head.lower, head.upper);
  FrontNodes other = front;
  ++other.boxes[place].upper[1];
  expect_refused(key_of(Kind::front, 0), encode_front(other, tetrahedra, codes));
  other = front;
  other.region_masks[place] ^= other.region_masks[place] == 1 ? 2U : 1U;
  expect_refused(key_of(Kind::front, 0), encode_front(other, tetrahedra, codes));
  for (const int what : {0, 1, 2}) {
    FrontFacts wrong = facts;
    if (what == 0) wrong.facts[place].error ^= 1;
    if (what == 1 && wrong.facts[place].low > 0) --wrong.facts[place].low;
    if (what == 2) wrong.world_errors[place] ^= 1;
    if (wrong.facts == facts.facts && wrong.world_errors == facts.world_errors) continue;
    expect_refused(key_of(Kind::front_facts, 0),
                   encode_front_facts(wrong, front.nodes, tetrahedra, base.values, base.scale));
  }
}

}  // namespace
}  // namespace lode::tetra_mt
