// Hierarchies of midpoints in files.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/midpoint/file_layout.h"
#include "lode/models/tetra_mt/midpoint/forest_blocks.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/file_fixtures.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Random;
using test::midpoints_of;
using test::noise;

Demand corner_demand(double tolerance) {
  FocusDemand demand;
  demand.foci = {BoxFocus{{{{0.1, 0.1, 0.1}}, {{0.3, 0.3, 0.3}}}}};
  demand.inside = tolerance;
  return demand;
}

class midpoint_file : public testing::Test {
 protected:
  ~midpoint_file() override {
    for (const char* const end : {"", ".lying.lode", ".part.lode"})
      std::filesystem::remove(path_ + end);
  }
  void write(const Hierarchy& hierarchy) {
    Progress progress;
    const auto saved = save(hierarchy, path_, {2}, progress);
    ASSERT_TRUE(saved) << saved.error().message;
    EXPECT_EQ(*saved, std::filesystem::file_size(path_));
  }

  std::string path_ = fmt::format("{}lode_midpoint_{}.lode", testing::TempDir(), getpid());
};

/// By cell and corner.
std::vector<std::pair<Vec3d, double>> vertices_of(const MidpointCut& cut) {
  std::vector<std::pair<Vec3d, double>> vertices;
  for (const Tetrahedron& t : cut.cells())
    for (const std::uint32_t v : t) vertices.emplace_back(cut.position(v), cut.value(v));
  return vertices;
}

/// Both ways, for many queries, budgets among them.
void expect_same_answers(const Forest& ours, const Forest& theirs) {
  MidpointCut a(ours);
  MidpointCut b(theirs);
  Engine<MidpointCut> engine(a);
  Engine<MidpointCut> other(b);
  const std::vector<Demand> demands{
      corner_demand(0.02),  uniform_demand(0.3),      isovalue_demand(0.1, 0.02), corner_demand(0),
      uniform_demand(0.05), isovalue_demand(-0.3, 0), uniform_demand(0)};
  for (const Demand& demand : demands)
    for (const Budget budget : {Budget{}, Budget{.max_cells = 3000}}) {
      engine.set_query(demand, budget);
      other.set_query(demand, budget);
      engine.finish();
      other.finish();
      EXPECT_EQ(engine.cut().applied(), other.cut().applied());
      EXPECT_EQ(a.cells(), b.cells());
      EXPECT_TRUE(vertices_of(a) == vertices_of(b));
    }
  ASSERT_TRUE(a.check());
}

void expect_same_field(const Forest& opened, const Hierarchy& hierarchy, std::size_t f) {
  const ForestField& field = opened.head().fields[f];
  const ForestField& expected = hierarchy.fields[f];
  EXPECT_EQ(field.name, expected.name);
  EXPECT_EQ(field.type, expected.type);
  EXPECT_EQ(field.low, expected.low);
  EXPECT_EQ(field.high, expected.high);
  EXPECT_EQ(field.base_error, expected.base_error);
  for (std::size_t i = 0; i < hierarchy.roots.size(); ++i) {
    EXPECT_EQ(opened.root_code(i, f), hierarchy.root_code(i, f));
    EXPECT_EQ(opened.root_word(i, f), hierarchy.root_word(i, f));
  }
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node) {
    const Split split = opened.split(node, f);
    EXPECT_EQ(split.difference, hierarchy.difference(node, f));
    EXPECT_EQ(split.placement, hierarchy.placement(node, f));
    const std::uint32_t word = hierarchy.facts(node, f);
    EXPECT_EQ(opened.facts(node, f), word);
    EXPECT_EQ(field.codes.facts(NodeCodes::parts(word)),
              expected.codes.facts(NodeCodes::parts(word)));
    EXPECT_EQ(opened.code_of(node, f), hierarchy.code_of(hierarchy.n_vertices + node, f));
  }
  for (std::uint32_t leaf = 0; leaf < hierarchy.n_vertices; ++leaf) {
    const Code code = hierarchy.code_of(leaf, f);
    EXPECT_EQ(opened.position(leaf, code), hierarchy.position(leaf, code));
    EXPECT_EQ(opened.value(leaf, code, f), hierarchy.value(leaf, code, f));
  }
}

/// All that a file is to give back.
void expect_same(const Forest& opened, const Hierarchy& hierarchy) {
  const ForestHead& head = opened.head();
  EXPECT_EQ(head.n_vertices, hierarchy.n_vertices);
  ASSERT_EQ(head.fields.size(), hierarchy.fields.size());
  EXPECT_EQ(head.boundary_deviation, hierarchy.boundary_deviation);
  EXPECT_EQ(head.n_cells, hierarchy.n_cells);
  EXPECT_EQ(head.base, hierarchy.base);
  EXPECT_EQ(head.base_regions, hierarchy.base_regions);
  EXPECT_EQ(head.n_base_cells, hierarchy.n_base_cells);
  EXPECT_EQ(head.roots, hierarchy.roots);
  EXPECT_EQ(head.root_codes, hierarchy.root_codes);
  EXPECT_EQ(head.root_facts, hierarchy.root_facts);
  EXPECT_EQ(head.base_exact, hierarchy.base_exact);
  EXPECT_EQ(head.region_ids, hierarchy.region_ids);
  EXPECT_EQ(head.region_names, hierarchy.region_names);
  EXPECT_EQ(head.patches, hierarchy.patches);
  ASSERT_EQ(head.pages.n_pages(), hierarchy.pages.n_pages());
  ASSERT_EQ(head.n_nodes(), hierarchy.n_nodes());
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node) {
    const Split split = opened.split(node);
    const NodeRecord& record = hierarchy.nodes[node];
    EXPECT_EQ(split.children, hierarchy.children(node));
    for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(split.mask >> i & 1, record.is_second(i));
    EXPECT_TRUE(std::ranges::equal(split.regions, hierarchy.regions_of(node)));
    EXPECT_EQ(head.radii.radius(NodeCodes::parts(record.facts).radius),
              hierarchy.radii.radius(NodeCodes::parts(record.facts).radius));
    EXPECT_EQ(opened.parent(node), hierarchy.parent(hierarchy.n_vertices + node));
  }
  for (std::size_t f = 0; f < head.fields.size(); ++f) expect_same_field(opened, hierarchy, f);
  EXPECT_TRUE(opened.check());
}

/// At a tolerance of 0 of a field, bit for bit, with all others.
void expect_reference(const Forest& forest, const TetraMesh& mesh, const Hierarchy& hierarchy,
                      std::size_t field = 0) {
  MidpointCut cut(forest, field);
  Engine<MidpointCut> engine(cut);
  engine.set_query(uniform_demand(0));
  engine.finish();
  ASSERT_TRUE(cut.check());
  const TetraMesh reference = test::labelled(mesh, hierarchy);
  EXPECT_EQ(test::normalised(cut.cells()), test::normalised(reference.tetrahedra));
  for (const Tetrahedron& t : cut.cells())
    for (const std::uint32_t v : t) {
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(cut.position(v)[i]),
                  std::bit_cast<std::uint64_t>(reference.positions[v][i]));
      EXPECT_EQ(std::bit_cast<std::uint64_t>(cut.value(v)),
                std::bit_cast<std::uint64_t>(reference.fields[field].values[v]));
    }
  std::vector<std::uint32_t> leaves;
  for (std::uint32_t leaf = 0; leaf < forest.head().n_vertices; ++leaf)
    if (cut.has_vertex(leaf)) leaves.push_back(leaf);
  for (std::size_t f = 0; f < mesh.fields.size(); ++f) {
    const auto values = cut.values(leaves, f);
    ASSERT_TRUE(values) << values.error().message;
    for (std::size_t i = 0; i < leaves.size(); ++i)
      EXPECT_EQ(std::bit_cast<std::uint64_t>((*values)[i]),
                std::bit_cast<std::uint64_t>(reference.fields[f].values[leaves[i]]));
  }
}

TEST_F(midpoint_file, is_the_hierarchy_bit_for_bit) {
  TetraMesh doubles = oracles::noise_mesh(12, oracles::Cut::in_six, 9);
  for (Vec3d& p : doubles.positions) p = p * (1 / 3.0);
  for (double& value : doubles.fields[0].values) value = std::sin(7 * value) / 3;
  doubles.fields[0].values[77] = -0.0;
  doubles.positions[0] = {{-0.0, 0, 0}};
  TetraMesh level = oracles::noise_mesh(9, oracles::Cut::in_five, 1);
  std::ranges::fill(level.fields[0].values, -2.5);
  TetraMesh one = oracles::noise_mesh(2, oracles::Cut::in_six, 1);
  one.tetrahedra.resize(1);
  TetraMesh none = one;
  none.tetrahedra.clear();
  TetraMesh moved = noise();
  for (double& value : moved.fields[0].values) value = value * 1e-30 + 1e9;
  for (const TetraMesh& mesh : {noise(), doubles, level, one, none, moved,
                                test::with_fields(noise()), test::with_fields(one)}) {
    const Hierarchy hierarchy = midpoints_of(mesh, mesh.tetrahedra.size() / 50);
    write(hierarchy);
    auto opened = open(path_);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->forest.n_pages_loaded(), 0U);
    for (std::size_t f = 0; f < mesh.fields.size(); ++f)
      expect_reference(opened->forest, mesh, hierarchy, f);
    expect_same(opened->forest, hierarchy);
  }
}

/// What is asked of one field is not read of the others, and is the same whatever these are.
TEST_F(midpoint_file, reads_nothing_of_fields_that_are_not_asked_for) {
  const TetraMesh mesh = test::with_fields(oracles::noise_mesh(20, oracles::Cut::in_five, 5));
  const Hierarchy hierarchy = midpoints_of(mesh, 800);
  write(hierarchy);
  const Forest memory(hierarchy);
  for (const std::size_t asked : {0U, 1U, 3U}) {
    const auto opened = open(path_);
    ASSERT_TRUE(opened) << opened.error().message;
    MidpointCut cut(opened->forest, asked);
    Engine<MidpointCut> engine(cut);
    engine.set_query(corner_demand(0));
    engine.finish();
    ASSERT_TRUE(cut.check());
    MidpointCut other(memory, asked);
    Engine<MidpointCut> expected(other);
    expected.set_query(corner_demand(0));
    expected.finish();
    EXPECT_EQ(engine.cut().applied(), expected.cut().applied());
    EXPECT_TRUE(vertices_of(cut) == vertices_of(other));
    const std::uint32_t n_pages = opened->forest.n_pages_loaded();
    EXPECT_GT(n_pages, 0U);
    for (std::size_t f = 1; f < mesh.fields.size(); ++f)
      EXPECT_EQ(opened->forest.n_pages_loaded(f), f == asked ? n_pages : 0U);
  }
}

TEST_F(midpoint_file, answers_as_memory_does_and_reads_what_it_needs) {
  const Hierarchy hierarchy =
      midpoints_of(oracles::noise_mesh(oracles::trials(25, 19), oracles::Cut::in_five, 5),
                   oracles::trials(800, 350));
  write(hierarchy);
  const Forest memory(hierarchy);
  auto opened = open(path_);
  ASSERT_TRUE(opened) << opened.error().message;
  const std::uint64_t n_first = opened->reads().n_bytes;
  EXPECT_LT(n_first, opened->reads().file_size / 8);
  MidpointCut cut(opened->forest);
  Engine<MidpointCut> engine(cut);
  engine.set_query(corner_demand(0.2));
  engine.finish();
  EXPECT_GT(opened->forest.n_pages_loaded(), 0U);
  // Of pages only those are read that have a node which is applied.
  std::vector<bool> is_needed(opened->forest.head().pages.n_pages());
  for (const NodeId node : engine.cut().applied())
    is_needed[opened->forest.head().pages.locate(static_cast<std::uint32_t>(node)).page] = true;
  EXPECT_EQ(opened->forest.n_pages_loaded(), std::ranges::count(is_needed, true));
  EXPECT_LT(opened->reads().n_bytes, opened->reads().file_size / 2);
  expect_same_answers(opened->forest, memory);
}

TEST_F(midpoint_file, keeps_regions_and_patches) {
  TetraMesh mesh = noise();
  mesh.region_ids = {-5, 0, 7};
  mesh.region_names = {"shell", "", "inner part"};
  mesh.patches = {{-2, "inlet"}, {5, ""}};
  for (const Tetrahedron& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(length(centre - Vec3d{{0.5, 0.5, 0.5}}) < 0.3 ? 2U
                           : centre[0] < 0.5                             ? 0U
                                                                         : 1U);
    for (std::size_t place = 0; place < 4; ++place) {
      const auto face = others(t, place);
      const auto is_low = [&](std::size_t axis, double limit) {
        return std::ranges::all_of(
            face, [&](std::uint32_t v) { return mesh.positions[v][axis] <= limit; });
      };
      if (is_low(2, 0)) mesh.patch_faces.push_back({face, is_low(0, 0.5) ? 0U : 1U});
    }
  }
  const Hierarchy hierarchy = midpoints_of(mesh, 300);
  EXPECT_FALSE(hierarchy.mixed_nodes.empty());
  write(hierarchy);
  const auto opened = open(path_);
  ASSERT_TRUE(opened) << opened.error().message;
  expect_same(opened->forest, hierarchy);
  const Forest memory(hierarchy);
  expect_same_answers(opened->forest, memory);
  MidpointCut cut(opened->forest);
  Engine<MidpointCut> engine(cut);
  engine.set_query(uniform_demand(0));
  engine.finish();
  std::array<double, 3> volumes{};
  std::array<double, 3> expected{};
  const TetraMesh reference = test::labelled(mesh, hierarchy);
  for (const MidpointCut::Cell& cell : cut.slots())
    if (cut.is_inside(cell)) volumes[cell.region] += test::volume_of(reference, {cell.corners});
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    expected[mesh.regions[i]] += test::volume_of(mesh, {mesh.tetrahedra[i]});
  for (std::size_t r = 0; r < 3; ++r) EXPECT_NEAR(volumes[r], expected[r], 1e-12);
}

TEST_F(midpoint_file, that_lies_is_refused_or_gives_something_but_does_no_harm) {
  TetraMesh mesh = noise();
  mesh.region_ids = {1, 2};
  for (const Tetrahedron& t : mesh.tetrahedra)
    mesh.regions.push_back(mesh.positions[t[0]][0] < 0.5 ? 0 : 1);
  write(midpoints_of(test::with_fields(mesh), 300));
  Random random(6);
  const std::string lying = path_ + ".lying.lode";
  int n_opened = 0;
  for (int trial = 0; trial < oracles::trials(400, 120); ++trial) {
    test::rewrite(path_, lying, random);
    const auto opened = open(lying);
    if (!opened) {
      EXPECT_NE(opened.error().message.find(lying), std::string::npos) << opened.error().message;
      continue;
    }
    ++n_opened;
    const std::size_t n_fields = opened->forest.head().fields.size();
    MidpointCut cut(opened->forest, static_cast<std::size_t>(trial) % n_fields);
    Engine<MidpointCut> engine(cut);
    engine.set_query(trial % 2 == 0 ? uniform_demand(0.05) : corner_demand(0));
    engine.run([&] { return cut.is_damaged(); });
    engine.set_query(uniform_demand(0.3));
    engine.run([&] { return cut.is_damaged(); });
    const ForestHead& head = opened->forest.head();
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < head.n_labels(); ++v)
      if (cut.has_vertex(v)) vertices.push_back(v);
    for (std::size_t f = 0; f < n_fields; ++f) {
      const auto values = cut.values(vertices, f);
      if (!values) continue;
      EXPECT_TRUE(std::ranges::all_of(*values, [](double x) { return std::isfinite(x); }));
    }
    for (const MidpointCut::Cell& cell : cut.slots()) {
      if (cell.corners[0] == kNone) continue;
      EXPECT_LT(cell.region, cut.is_inside(cell) ? head.region_ids.size() : 1);
      for (const std::uint32_t v : cell.corners)
        if (v != head.outside()) {
          ASSERT_LT(v, head.outside());
          EXPECT_TRUE(std::isfinite(cut.value(v)));
        }
    }
    static_cast<void>(cut.check());
  }
  EXPECT_GT(n_opened, 20);
}

/// One child of two nodes: more vertices than leaves could be in the mesh at once.
TEST_F(midpoint_file, with_more_nodes_than_make_its_vertices_is_refused) {
  std::vector<PageCounts> pages(2);
  pages[0].groups = {{1, 4}};
  pages[0].n_leaves = 4;
  pages[1].groups = {{0, 2}};
  pages[1].n_leaves = 4;
  ForestHead head;
  head.n_base_leaves = 3;
  head.n_vertices = 11;
  head.pages = PageTable(3, pages);
  head.n_inner = head.pages.n_nodes();
  head.box = {{{0, 0, 0}}, {{1, 1, 1}}};
  head.n_cells = 100;
  head.n_base_cells = 4;
  for (std::uint32_t root = 0; root < 7; ++root) head.roots.push_back(root);
  for (std::uint32_t cell = 0; cell < 4; ++cell) head.base.push_back({0, 1, 2, 3 + cell});
  NodeCodes::Knots knots{};
  for (std::size_t i = 0; i < knots.size(); ++i) knots[i] = static_cast<double>(i) / 63;
  const Scale scale(-30, std::int64_t{0});
  head.scales = Scales(std::array{scale, scale, scale});
  head.radii = RadiusCodes(10);
  head.fields.push_back({.name = "f", .high = 1, .scale = scale, .codes = NodeCodes(knots, 1)});
  auto writer = store::Writer::create(path_, "tetra_mt_midpoint", encode_head(head));
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->append(key_of(Kind::table, 0), as_block(encode_table(pages))));
  for (std::uint32_t page = 0; page < 2; ++page)
    ASSERT_TRUE(writer->append(key_of(Kind::page, page), as_block(encode_table(pages))));
  ASSERT_TRUE(writer->finish());
  const auto opened = open(path_);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("expected 4 nodes, which make 11 vertices of 7, got 6"),
            std::string::npos)
      << opened.error().message;
}

TEST_F(midpoint_file, that_was_cut_off_or_is_another_model_is_refused) {
  write(midpoints_of(noise(), 300));
  std::ifstream in(path_, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  const std::string part = path_ + ".part.lode";
  std::ofstream(part, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  EXPECT_FALSE(open(part));
  auto writer = store::Writer::create(part, "tetra_mt", {});
  ASSERT_TRUE(writer && writer->finish());
  EXPECT_FALSE(is_model_of(part));
  const auto other = open(part);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("expected the model tetra_mt_midpoint"), std::string::npos);
  auto unknown = store::Writer::create(part, kModelName, std::vector<std::byte>(4, std::byte{9}));
  ASSERT_TRUE(unknown && unknown->finish());
  const auto later = open(part);
  ASSERT_FALSE(later);
  EXPECT_NE(later.error().message.find("expected layout 6 of midpoints, got 151587081"),
            std::string::npos);
}

TEST_F(midpoint_file, is_the_same_for_any_number_of_threads) {
  const auto bytes = [&](int threads) {
    Progress progress;
    const TetraMesh mesh = test::with_fields(noise());
    const auto collapses =
        collapse_edges(mesh, {.base_cells = 300, .threads = {threads}}, progress);
    const auto hierarchy = make_hierarchy(mesh, *collapses, {threads});
    EXPECT_TRUE(save(*hierarchy, path_, {threads}, progress));
    std::ifstream in(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(bytes(1), bytes(3));
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
