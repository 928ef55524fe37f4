// Hierarchies in files.

#include "lode/models/tetra_mt/persist.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/gradient_codes.h"
#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/page_primers.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "lode/store/writer.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/file_fixtures.h"
#include "tests/tetra/mesh_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Random;
using test::codes_of;
using test::hierarchy_of;
using test::noise;
using test::rewrite;

Demand box_demand(double tolerance) {
  FocusDemand demand;
  demand.foci = {BoxFocus{{{{0.1, 0.1, 0.1}}, {{0.4, 0.4, 0.4}}}}};
  demand.inside = tolerance;
  return demand;
}

class tetra_file : public testing::Test {
 protected:
  tetra_file() : mesh_(noise()), hierarchy_(hierarchy_of(mesh_, 300)) {
    Progress progress;
    EXPECT_TRUE(
        save(hierarchy_, mesh_.tetrahedra.size(), codes_of(hierarchy_), path_, {2}, progress));
  }

  ~tetra_file() override {
    for (const char* const end : {"", ".lying.lode", ".part.lode"})
      std::filesystem::remove(path_ + end);
  }

  std::string path_ = fmt::format("{}lode_tetra_{}.lode", testing::TempDir(), getpid());
  TetraMesh mesh_;
  Hierarchy hierarchy_;
};

TEST_F(tetra_file, answers_as_memory_does_and_reads_what_it_needs) {
  const auto memory = PackedHierarchy::pack(hierarchy_, mesh_.tetrahedra.size(), {2});
  for (const double tolerance : {0.3, 0.02, 0.0}) {
    auto opened = open(path_);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->hierarchy.n_pages_loaded(), 0U);
    TetraCut ours(opened->hierarchy);
    TetraCut theirs(memory);
    Engine<TetraCut> engine(ours);
    Engine<TetraCut> other(theirs);
    engine.set_query(box_demand(tolerance));
    other.set_query(box_demand(tolerance));
    engine.finish();
    other.finish();
    EXPECT_EQ(engine.cut().applied(), other.cut().applied());
    EXPECT_EQ(ours.cells(), theirs.cells());
    EXPECT_TRUE(ours.check());
    if (tolerance > 0.1) {
      EXPECT_LT(opened->reads().n_bytes, 3 * opened->reads().file_size / 4);
    }
  }
  auto opened = open(path_);
  TetraCut cut(opened->hierarchy);
  for (const std::uint32_t node : hierarchy_.order) cut.apply(NodeId{node});
  EXPECT_EQ(cut.cells().size(), mesh_.tetrahedra.size());
  for (std::uint32_t v = 0; v < hierarchy_.positions.size(); ++v) {
    EXPECT_EQ(opened->hierarchy.position(v), hierarchy_.positions[v]);
    EXPECT_EQ(opened->hierarchy.value(v, 0), hierarchy_.fields[0].values[v]);
  }
  const PageShape& shape = opened->hierarchy.head().shape;
  const std::vector<std::uint32_t> codes = codes_of(hierarchy_)(0);
  std::vector<std::uint32_t> found(codes.size());
  for (std::uint32_t v = 0; v < codes.size(); ++v) {
    const VertexRange range = vertices_of(shape, page_of(shape, v));
    ASSERT_LT(v - range.first, range.n);
    if (v != range.first) continue;
    const auto page = opened->gradients(0, page_of(shape, v));
    ASSERT_TRUE(page);
    std::ranges::copy(*page, found.begin() + v);
  }
  EXPECT_EQ(found, codes);
}

/// One of floats, one of doubles, one of a single value.
TetraMesh with_three_fields(TetraMesh mesh) {
  for (const char* const name : {"wide", "level"}) {
    mesh.fields.push_back(mesh.fields[0]);
    mesh.fields.back().name = name;
  }
  for (double& value : mesh.fields[1].values) value = std::sin(7 * value) / 3;
  std::ranges::fill(mesh.fields[2].values, -2.5);
  return mesh;
}

TEST_F(tetra_file, keeps_fields_apart_and_reads_those_that_are_asked_for) {
  const TetraMesh mesh = with_three_fields(mesh_);
  const Hierarchy hierarchy = hierarchy_of(mesh, 600);
  Progress progress;
  ASSERT_TRUE(save(hierarchy, mesh.tetrahedra.size(), codes_of(hierarchy), path_, {2}, progress));
  const auto memory = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), {2});
  std::uint64_t n_read = 0;
  for (const std::size_t field : {1U, 0U, 2U}) {
    const auto opened = open(path_);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->hierarchy.head().fields.size(), 3U);
    EXPECT_EQ(opened->hierarchy.head().fields[field].name, mesh.fields[field].name);
    TetraCut ours(opened->hierarchy, field);
    TetraCut theirs(memory, field);
    Engine<TetraCut> engine(ours);
    Engine<TetraCut> other(theirs);
    for (const double share : {0.5, 0.0}) {
      const double tolerance = share * memory.head().fields[field].base_error;
      engine.set_query(uniform_demand(tolerance));
      other.set_query(uniform_demand(tolerance));
      engine.finish();
      other.finish();
      EXPECT_EQ(engine.cut().applied(), other.cut().applied());
    }
    const auto is_whole = opened->hierarchy.check();
    ASSERT_TRUE(is_whole) << is_whole.error().message;
    EXPECT_EQ(opened->hierarchy.n_pages_loaded(), memory.head().shape.n_pages());
    for (std::size_t f = 0; f < 3; ++f)
      EXPECT_EQ(opened->hierarchy.n_field_pages_loaded(f),
                f == field ? memory.head().shape.n_pages() : 0U);
    if (field == 2) {
      EXPECT_LT(opened->reads().n_bytes, n_read);
    }
    n_read = opened->reads().n_bytes;
    for (std::uint32_t v = 0; v < hierarchy.positions.size(); ++v) {
      EXPECT_EQ(opened->hierarchy.value(v, field), hierarchy.fields[field].values[v]);
      if (v % 100 == 0) {
        EXPECT_EQ(
            opened->gradients(field, page_of(memory.head().shape, v)).value()[0],
            codes_of(hierarchy)(
                field)[vertices_of(memory.head().shape, page_of(memory.head().shape, v)).first]);
      }
    }
    EXPECT_EQ(opened->mesh_vertices().value(), hierarchy.mesh_vertices);
  }
}

/// By its corners' positions, each tetrahedron's region.
std::map<std::array<Vec3d, 4>, std::int64_t> regions_by_corners(const TetraMesh& mesh) {
  std::map<std::array<Vec3d, 4>, std::int64_t> regions;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    std::array<Vec3d, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) corners[k] = mesh.positions[mesh.tetrahedra[i][k]];
    std::ranges::sort(corners, {}, [](const Vec3d& p) { return p.v; });
    regions[corners] = mesh.region_ids[mesh.regions[i]];
  }
  return regions;
}

TEST_F(tetra_file, keeps_regions_through_refining_and_coarsening) {
  TetraMesh mesh = noise();
  mesh.region_ids = {-5, 0, 7};
  Random random(12);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    const bool is_inner = length(centre - Vec3d{{0.5, 0.5, 0.5}}) < 0.3;
    mesh.regions.push_back(is_inner ? 2U : centre[0] < 0.5 ? 0U : 1U);
  }
  const Hierarchy hierarchy = hierarchy_of(mesh, 300);
  Progress progress;
  ASSERT_TRUE(save(hierarchy, mesh.tetrahedra.size(), codes_of(hierarchy), path_, {2}, progress));
  const auto opened = open(path_);
  ASSERT_TRUE(opened) << opened.error().message;
  TetraCut cut(opened->hierarchy);
  for (int round = 0; round < 2; ++round) {
    for (const std::uint32_t node : hierarchy.order) cut.apply(NodeId{node});
    TetraMesh found{.positions = hierarchy.positions, .region_ids = mesh.region_ids};
    for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
      const TetraCut::Cell& cell = cut.slots()[slot];
      if (!cut.is_inside(cell)) continue;
      found.tetrahedra.push_back(cell.corners);
      found.regions.push_back(cut.region(slot));
    }
    // Compared as maps: whoever is of another region differs.
    EXPECT_TRUE(regions_by_corners(found) == regions_by_corners(mesh));
    for (std::size_t i = hierarchy.order.size(); i-- > 0;) cut.undo(NodeId{hierarchy.order[i]});
  }
}

/// The file's metadata with other names of regions: three, of a short name each.
std::string with_name(const HierarchyHead& head, const std::string& name, std::uint32_t n_bytes) {
  std::vector<std::byte> bytes = encode_head(head);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t at = text.find("rotor");
  std::string count(4, '\0');
  std::memcpy(count.data(), &n_bytes, 4);
  return text.substr(0, at - 4) + count + name + text.substr(at + 5);
}

TEST_F(tetra_file, keeps_names_of_regions_and_refuses_what_is_none) {
  TetraMesh mesh = noise();
  mesh.region_ids = {-5, 0, 7};
  mesh.region_names = {"", "rotor", "\xC3\xA9t\xC3\xA9"};
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    mesh.regions.push_back(mesh.positions[mesh.tetrahedra[i][0]][0] < 0.5 ? 0U : 1U + i % 2);
  const Hierarchy hierarchy = hierarchy_of(mesh, 300);
  Progress progress;
  ASSERT_TRUE(save(hierarchy, mesh.tetrahedra.size(), codes_of(hierarchy), path_, {2}, progress));
  const auto opened = open(path_);
  ASSERT_TRUE(opened) << opened.error().message;
  const HierarchyHead& head = opened->hierarchy.head();
  EXPECT_EQ(head.region_ids, mesh.region_ids);
  EXPECT_EQ(head.region_names, mesh.region_names);
  const auto refusal = [&](const std::string& name, std::uint32_t n_bytes) {
    const std::string text = with_name(head, name, n_bytes);
    BaseCounts counts;
    const auto read = decode_head(std::as_bytes(std::span(text)), "x.lode", counts);
    return read ? std::string("taken") : read.error().message;
  };
  EXPECT_EQ(refusal("rotor", 5), "taken");
  EXPECT_EQ(refusal("rot\xFFr", 5),
            "x.lode: metadata: expected names of regions in one line of UTF-8, got byte 0xff at 3, "
            "which is no UTF-8");
  EXPECT_NE(refusal("ro\ntr", 5).find("a control character at byte 2"), std::string::npos);
  EXPECT_NE(refusal(std::string(5000, 'x'), 5000).find("5000 bytes, more than 4096"),
            std::string::npos);
  for (const std::uint32_t n : {0x80000000U, 0xFFFFFFFFU})
    EXPECT_NE(refusal("rotor", n).find("bytes at byte"), std::string::npos) << refusal("rotor", n);
  // Many regions in few bytes.
  std::string text = with_name(head, "rotor", 5);
  const std::size_t at = text.find("rotor") - 4 - 8 - 4 - 8 - 4;
  text.replace(at, 4, "\xFF\xFF\xFF\xFF");
  BaseCounts counts;
  const auto many = decode_head(std::as_bytes(std::span(text)), "x.lode", counts);
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().message.find("expected 4294967295 regions in"), std::string::npos)
      << many.error().message;
}

TEST_F(tetra_file, is_not_built_with_names_of_regions_that_are_none) {
  TetraMesh mesh = noise();
  mesh.region_ids = {3, 4};
  mesh.regions.assign(mesh.tetrahedra.size(), 0);
  mesh.regions[0] = 1;
  Progress progress;
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"one"}, {"a", "b", "c"}, {"a", "b\n"}, {"\xC3", ""}}) {
    mesh.region_names = names;
    const auto made = collapse_half_edges(mesh, {.base_cells = 300}, progress);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message.find("names of regions"), std::string::npos);
  }
}

TEST_F(tetra_file, keeps_doubles) {
  TetraMesh mesh = mesh_;
  for (Vec3d& p : mesh.positions) p = p * (1 / 3.0);
  for (double& value : mesh.fields[0].values) value /= 7;
  const Hierarchy hierarchy = hierarchy_of(mesh, 500);
  Progress progress;
  ASSERT_TRUE(save(hierarchy, mesh.tetrahedra.size(), codes_of(hierarchy), path_, {2}, progress));
  const auto opened = open(path_);
  ASSERT_TRUE(opened);
  for (std::uint32_t v = 0; v < hierarchy.positions.size(); ++v) {
    EXPECT_EQ(opened->hierarchy.position(v), hierarchy.positions[v]);
    EXPECT_EQ(opened->hierarchy.value(v, 0), hierarchy.fields[0].values[v]);
  }
}

/// Of the noise: a patch of half the floor, and one of what is beside.
TetraMesh with_patches(TetraMesh mesh) {
  mesh.patches = {{-2, "inlet"}, {5, ""}};
  std::vector<Tetrahedron> closed = mesh.tetrahedra;
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  EXPECT_TRUE(close_boundary(n, closed, {1}));
  for (std::size_t i = mesh.tetrahedra.size(); i < closed.size(); ++i) {
    const auto at = std::ranges::find(closed[i], n) - closed[i].begin();
    const auto face = others(closed[i], static_cast<std::size_t>(at));
    const auto is_low = [&](std::size_t axis, double limit) {
      return std::ranges::all_of(face,
                                 [&](std::uint32_t v) { return mesh.positions[v][axis] <= limit; });
    };
    if (is_low(2, 0)) mesh.patch_faces.push_back({face, is_low(0, 0.5) ? 0U : 1U});
  }
  return mesh;
}

TEST_F(tetra_file, with_patches_that_lies_does_no_harm) {
  const Hierarchy hierarchy = hierarchy_of(with_patches(noise()), 300);
  Progress progress;
  ASSERT_TRUE(save(hierarchy, mesh_.tetrahedra.size(), codes_of(hierarchy), path_, {2}, progress));
  const auto whole = open(path_);
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(whole->hierarchy.head().patches, hierarchy.patches);
  EXPECT_EQ(whole->hierarchy.head().base_regions, hierarchy.base_regions);
  Random random(8);
  const std::string lying = path_ + ".lying.lode";
  for (int trial = 0; trial < 100; ++trial) {
    rewrite(path_, lying, random);
    const auto opened = open(lying);
    if (!opened) continue;
    TetraCut cut(opened->hierarchy);
    Engine<TetraCut> engine(cut);
    engine.set_query(uniform_demand(0.05));
    engine.run([&] { return cut.is_damaged(); });
    const HierarchyHead& head = opened->hierarchy.head();
    for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
      const TetraCut::Cell& cell = cut.slots()[slot];
      if (cell.corners[0] == kNone) continue;
      if (cut.is_inside(cell))
        EXPECT_LT(cut.region(slot), std::max<std::size_t>(head.region_ids.size(), 1));
      else
        EXPECT_LE(cut.region(slot), head.patches.size());
    }
  }
}

TEST_F(tetra_file, that_lies_is_refused_or_gives_something_but_does_no_harm) {
  Random random(6);
  const std::string lying = path_ + ".lying.lode";
  for (int trial = 0; trial < 150; ++trial) {
    rewrite(path_, lying, random);
    const auto opened = open(lying);
    if (!opened) continue;
    TetraCut cut(opened->hierarchy);
    Engine<TetraCut> engine(cut);
    engine.set_query(trial % 2 == 0 ? uniform_demand(0.05) : box_demand(0));
    engine.run([&] { return cut.is_damaged(); });
    // Back, where parents and children may not agree.
    engine.set_query(uniform_demand(0.3));
    engine.run([&] { return cut.is_damaged(); });
    for (const Tetrahedron& t : cut.cells())
      for (const std::uint32_t v : t) EXPECT_LT(v, opened->hierarchy.head().outside());
    static_cast<void>(cut.check());
  }
}

/// Other pages begin with what these taught.
TEST_F(tetra_file, of_which_a_primer_is_damaged_says_so_whatever_page_is_asked_for) {
  const auto reader = store::Reader::open(path_);
  ASSERT_TRUE(reader);
  std::ifstream in(path_, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  const std::uint32_t n_pages = n_pages_of(hierarchy_.n_nodes());
  ASSERT_GT(n_pages, kMostPrimers);
  const std::string part = path_ + ".part.lode";
  for (const Kind kind : {Kind::links, Kind::field, Kind::gradients}) {
    const auto primers = primers_of(
        n_pages + (kind == Kind::gradients ? n_pages_of(hierarchy_.n_base_vertices) : 0));
    const store::BlockKey key = key_of(kind, primers[1]);
    const auto block = std::ranges::find(reader->blocks(), key, &store::BlockEntry::key);
    ASSERT_NE(block, reader->blocks().end());
    std::string damaged = bytes;
    damaged[block->offset + block->stored_size / 2] ^= 1;
    std::ofstream(part, std::ios::binary | std::ios::trunc) << damaged;
    const auto opened = open(part);
    ASSERT_TRUE(opened) << opened.error().message;
    const auto expect_named = [&](const auto& result) {
      ASSERT_FALSE(result);
      EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
      EXPECT_NE(result.error().message.find(store::describe(key)), std::string::npos)
          << result.error().message;
    };
    ASSERT_EQ(std::ranges::count(primers, 0U), 0);
    const auto codes = opened->gradients(0, 0);
    EXPECT_EQ(codes.has_value(), kind != Kind::gradients);
    if (kind == Kind::gradients) expect_named(codes);
    static_cast<void>(opened->hierarchy.links(0));
    EXPECT_EQ(opened->hierarchy.check().has_value(), kind != Kind::links);
    static_cast<void>(opened->hierarchy.value(hierarchy_.n_base_vertices, 0));
    if (kind != Kind::gradients) expect_named(opened->hierarchy.check());
    if (kind == Kind::gradients) EXPECT_TRUE(opened->hierarchy.check());
  }
}

/// Everything but gradients and the mesh's numbers, byte for byte.
TEST_F(tetra_file, may_be_without_what_queries_do_without) {
  const std::string part = path_ + ".part.lode";
  Progress progress;
  ASSERT_TRUE(save(hierarchy_, mesh_.tetrahedra.size(), nullptr, part, {2}, progress));
  const auto lean = open(part);
  ASSERT_TRUE(lean) << lean.error().message;
  EXPECT_FALSE(lean->gradients);
  EXPECT_FALSE(lean->mesh_vertices);
  const auto whole = open(path_);
  EXPECT_TRUE(whole->gradients);
  EXPECT_TRUE(whole->mesh_vertices);
  const auto all = store::Reader::open(path_);
  const auto some = store::Reader::open(part);
  std::size_t n_kept = 0;
  for (const store::BlockEntry& block : all->blocks()) {
    const auto kind = static_cast<Kind>(block.key.kind);
    const bool is_kept = kind != Kind::gradients && kind != Kind::mesh_vertices;
    const auto same = std::ranges::find(some->blocks(), block.key, &store::BlockEntry::key);
    ASSERT_EQ(same != some->blocks().end(), is_kept);
    if (!is_kept) continue;
    EXPECT_EQ(same->stored_size, block.stored_size);
    EXPECT_EQ(same->checksum, block.checksum);
    ++n_kept;
  }
  EXPECT_EQ(n_kept, some->blocks().size());
  TetraCut ours(lean->hierarchy);
  TetraCut theirs(whole->hierarchy);
  Engine<TetraCut> engine(ours);
  Engine<TetraCut> other(theirs);
  for (const double tolerance : {0.3, 0.0}) {
    engine.set_query(box_demand(tolerance));
    other.set_query(box_demand(tolerance));
    engine.finish();
    other.finish();
    EXPECT_EQ(ours.cells(), theirs.cells());
  }
}

/// All of what a lean file is without must be there, or none.
TEST_F(tetra_file, that_is_without_some_of_its_blocks_is_refused) {
  const auto reader = store::Reader::open(path_);
  ASSERT_TRUE(reader);
  const std::string part = path_ + ".part.lode";
  for (const Kind kind : {Kind::links, Kind::field, Kind::gradients, Kind::mesh_vertices})
    for (const std::uint32_t page : {0U, 1U}) {
      const store::BlockKey missing = key_of(kind, page);
      auto writer = store::Writer::create(part, reader->model(),
                                          {reader->metadata().begin(), reader->metadata().end()});
      ASSERT_TRUE(writer);
      for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
        if (reader->blocks()[i].key == missing) continue;
        const auto bytes = reader->read_block(i);
        ASSERT_TRUE(bytes);
        ASSERT_TRUE(writer->append(reader->blocks()[i].key,
                                   store::encode_block_as(store::Codec::none, {.raw = *bytes})));
      }
      ASSERT_TRUE(writer->finish());
      const auto opened = open(part);
      ASSERT_FALSE(opened);
      EXPECT_NE(opened.error().message.find(store::describe(missing)), std::string::npos)
          << opened.error().message;
    }
}

TEST_F(tetra_file, that_was_cut_off_or_is_another_model_is_refused) {
  std::ifstream in(path_, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  const std::string part = path_ + ".part.lode";
  std::ofstream(part, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  EXPECT_FALSE(open(part));
  std::ofstream(part, std::ios::binary | std::ios::trunc);
  EXPECT_FALSE(open(part));
  auto writer = store::Writer::create(part, "diamond3d", {});
  ASSERT_TRUE(writer && writer->finish());
  const auto other = open(part);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("expected the model tetra_mt"), std::string::npos);
}

}  // namespace
}  // namespace lode::tetra_mt
