#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode::hierarchy_file {
namespace {

using test::LatticePoint;
using triangle_hierarchy::Hierarchy;
using triangle_hierarchy::kNone;

terrain_file::Source source_of(const HeightGrid& grid) {
  terrain_file::Source source;
  source.frame = grid;
  source.frame.crs = "a CRS";
  source.frame.vertical_unit = "metre";
  source.range = height_range(grid);
  source.sample_type = "int16";
  source.has_place = false;
  source.n_samples = 5;
  source.n_missing = 6;
  source.n_left_out = 7;
  return source;
}

HierarchyModel build(Kind kind, const HeightGrid& grid, const std::vector<double>& levels) {
  Progress progress;
  HierarchyModel model{source_of(grid), kind, {}};
  if (kind == Kind::adaptive_triangulation)
    model.hierarchy = adaptive_triangulation::build(grid, levels, {2}, progress)->hierarchy;
  else
    model.hierarchy = hierarchical_delaunay::build(grid, levels, {2}, progress)->hierarchy;
  return model;
}

constexpr std::array kKinds{Kind::adaptive_triangulation, Kind::hierarchical_delaunay};

/// Triangles over 4 x 4 samples, whose lattice is no finer: by levels, without refinements yet.
HierarchyModel drawn(const std::vector<LatticePoint>& vertices,
                     const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  HierarchyModel model;
  model.source = source_of(test::make_grid<float>(4, 4, [](int, int) { return 1; }));
  Hierarchy& h = model.hierarchy;
  h.frame = model.source.frame;
  h.tolerances = {5};
  h.vertices = vertices;
  h.heights.assign(vertices.size(), 1);
  for (const auto& corner : triangles) h.triangles.push_back({corner, {}, kNone, 0});
  h.vertices_until = {static_cast<std::uint32_t>(vertices.size())};
  h.triangles_until = {static_cast<std::uint32_t>(triangles.size())};
  return model;
}

/// The same over scattered points, here all nodes that are vertices.
HierarchyModel drawn_of_points(const std::vector<LatticePoint>& vertices,
                               const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  HierarchyModel model = drawn(vertices, triangles);
  model.source.is_of_points = model.hierarchy.is_of_points = true;
  return model;
}

/// A triangle and what refines it.
HierarchyModel refined_of_points(const std::vector<LatticePoint>& vertices,
                                 const std::vector<std::array<std::uint32_t, 3>>& parts) {
  std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}};
  triangles.insert(triangles.end(), parts.begin(), parts.end());
  HierarchyModel model = drawn_of_points(vertices, triangles);
  const auto n = static_cast<std::uint32_t>(vertices.size());
  model.hierarchy.tolerances = {5, 2};
  model.hierarchy.vertices_until = {3, n};
  model.hierarchy.triangles_until = {1, static_cast<std::uint32_t>(triangles.size())};
  model.hierarchy.refinements = {{0, 1}};
  model.hierarchy.triangles[0].refinement = 0;
  return model;
}

void expect_same(const HierarchyModel& a, const HierarchyModel& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.source.frame.to_world, b.source.frame.to_world);
  EXPECT_EQ(a.source.frame.crs, b.source.frame.crs);
  EXPECT_EQ(a.source.sample_type, b.source.sample_type);
  EXPECT_EQ(a.source.has_place, b.source.has_place);
  EXPECT_EQ(a.source.n_left_out, b.source.n_left_out);
  const Hierarchy& h = a.hierarchy;
  const Hierarchy& o = b.hierarchy;
  EXPECT_EQ(o.frame.n_columns, h.frame.n_columns);
  EXPECT_EQ(o.bits, h.bits);
  EXPECT_EQ(o.tolerances, h.tolerances);
  EXPECT_EQ(o.vertices, h.vertices);
  EXPECT_EQ(o.heights, h.heights);
  EXPECT_EQ(o.in_rows, h.in_rows);
  EXPECT_EQ(o.vertices_until, h.vertices_until);
  EXPECT_EQ(o.triangles_until, h.triangles_until);
  EXPECT_EQ(o.reach, h.reach);
  EXPECT_EQ(o.lines, h.lines);
  EXPECT_EQ(o.is_of_points, h.is_of_points);
  EXPECT_EQ(o.crowded, h.crowded);
  ASSERT_EQ(o.triangles.size(), h.triangles.size());
  for (std::size_t t = 0; t < h.triangles.size(); ++t) {
    EXPECT_EQ(o.triangles[t].corner, h.triangles[t].corner);
    EXPECT_EQ(o.triangles[t].twin, h.triangles[t].twin);
    EXPECT_EQ(o.triangles[t].refinement, h.triangles[t].refinement);
    EXPECT_EQ(o.triangles[t].error, h.triangles[t].error);
  }
  ASSERT_EQ(o.refinements.size(), h.refinements.size());
  for (std::size_t r = 0; r < h.refinements.size(); ++r) {
    EXPECT_EQ(o.refinements[r].triangle, h.refinements[r].triangle);
    EXPECT_EQ(o.refinements[r].first, h.refinements[r].first);
  }
}

class hierarchy_file : public testing::Test {
 protected:
  ~hierarchy_file() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(other_);
  }
  HierarchyModel saved_and_opened(const HierarchyModel& model) {
    const auto size = save(model, path_, progress_);
    EXPECT_TRUE(size) << size.error().message;
    EXPECT_EQ(*size, std::filesystem::file_size(path_));
    auto opened = open(path_, progress_);
    EXPECT_TRUE(opened) << opened.error().message;
    return *std::move(opened);
  }
  void expect_refused(const HierarchyModel& model, const std::string& why) {
    ASSERT_TRUE(save(model, path_, progress_));
    const auto opened = open(path_, progress_);
    ASSERT_FALSE(opened) << why;
    const std::string& message = opened.error().message;
    EXPECT_NE(message.find(path_), std::string::npos) << message;
    EXPECT_NE(message.find(why), std::string::npos) << message << "\nfor: " << why;
  }

  Progress progress_;
  const std::string path_ =
      testing::TempDir() + "lode_hierarchy_" + std::to_string(::getpid()) + ".lode";
  const std::string other_ =
      testing::TempDir() + "lode_hierarchy_lie_" + std::to_string(::getpid()) + ".lode";
};

TEST_F(hierarchy_file, has_all_that_was_saved_and_finds_twins_again) {
  for (const Kind kind : kKinds)
    for (const test::TerrainCase& c : test::terrain_cases()) {
      HierarchyModel made = build(kind, c.grid, {150, 7, 0});
      made.hierarchy.lines = {{0, 1}, {2, 0}};
      SCOPED_TRACE(testing::Message() << c.name << ", " << static_cast<int>(kind));
      expect_same(made, saved_and_opened(made));
    }
}

TEST_F(hierarchy_file, is_of_these_models_alone) {
  const HierarchyModel model = drawn({{0, 0}, {3, 0}, {3, 3}, {0, 3}}, {{0, 1, 2}, {0, 2, 3}});
  ASSERT_TRUE(save(model, path_, progress_));
  EXPECT_TRUE(HierarchyFile::open(path_));
  EXPECT_FALSE(HierarchyFile::open(other_));
  auto writer = store::Writer::create(other_, "restricted_quadtree", {});
  ASSERT_TRUE(writer && writer->finish());
  EXPECT_FALSE(HierarchyFile::open(other_));
  EXPECT_FALSE(open(other_, progress_));
}

TEST_F(hierarchy_file, stops_when_cancelled) {
  const HierarchyModel model = drawn({{0, 0}, {3, 0}, {3, 3}, {0, 3}}, {{0, 1, 2}, {0, 2, 3}});
  ASSERT_TRUE(save(model, path_, progress_));
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(open(path_, cancelled));
  EXPECT_FALSE(save(model, other_, cancelled));
  EXPECT_FALSE(std::filesystem::exists(other_));
}

TEST_F(hierarchy_file, has_its_first_levels_without_the_others) {
  for (const Kind kind : {Kind::adaptive_triangulation, Kind::hierarchical_delaunay}) {
    const HierarchyModel made =
        build(kind, test::make_grid<float>(33, 29, test::hills_with_spikes), {150, 40, 7});
    ASSERT_TRUE(save(made, path_, progress_));
    const auto file = HierarchyFile::open(path_);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->head().n_bytes(), made.hierarchy.n_bytes());
    for (int level = 0; level < 3; ++level) {
      EXPECT_EQ(file->head().n_triangles_in(level), made.hierarchy.n_triangles_in(level));
      const auto read = file->read(level + 1, progress_);
      ASSERT_TRUE(read) << read.error().message;
      const Hierarchy& h = read->hierarchy;
      EXPECT_EQ(h.n_levels(), level + 1);
      EXPECT_EQ(h.vertices.size(), made.hierarchy.vertices_until[static_cast<std::size_t>(level)]);
      const auto expected = tin_of_level(made.hierarchy, level, delaunay::TinLinks::kept);
      const auto tin = tin_of_level(h, level, delaunay::TinLinks::kept);
      EXPECT_EQ(tin.vertices, expected.vertices);
      EXPECT_EQ(tin.triangles, expected.triangles);
      EXPECT_EQ(tin.errors, expected.errors);
      EXPECT_EQ(tin.twins, expected.twins);
    }
  }
}

/// So nothing of that level is read before.
TEST_F(hierarchy_file, is_refused_for_a_damaged_level_when_that_is_read) {
  oracles::Random random(5);
  const auto noise =
      test::make_grid<float>(140, 140, [&](int, int) { return random.uniform(-500, 500); });
  const HierarchyModel made = build(Kind::hierarchical_delaunay, noise, {600, 0});
  ASSERT_TRUE(save(made, path_, progress_));
  std::uint64_t offset = 0;
  {
    const auto reader = store::Reader::open(path_);
    ASSERT_TRUE(reader);
    // The second of the corners' blocks.
    const auto block = reader->find({4, 0, {{1, 0, 0}}});
    ASSERT_TRUE(block);
    offset = reader->blocks()[*block].offset;
  }
  std::fstream bytes(path_, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekg(static_cast<std::streamoff>(offset));
  const int byte = bytes.get();
  bytes.seekp(static_cast<std::streamoff>(offset));
  bytes.put(static_cast<char>(byte ^ 1));
  bytes.close();
  const auto file = HierarchyFile::open(path_);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->read(1, progress_));
  const auto all = file->read(2, progress_);
  ASSERT_FALSE(all);
  EXPECT_NE(all.error().message.find(path_), std::string::npos);
}

TEST_F(hierarchy_file, refuses_numbers_that_cannot_be) {
  HierarchyModel made = build(Kind::hierarchical_delaunay,
                              test::make_grid<float>(17, 13, test::hills_with_spikes), {90, 20});
  made.hierarchy.lines = {{0, 1}, {2, 0}};
  ASSERT_GE(made.hierarchy.refinements.size(), 3U);
  const auto n = static_cast<std::uint32_t>(made.hierarchy.triangles.size());
  struct Lie {
    const char* why;
    std::function<void(HierarchyModel&)> tell;
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const std::vector<Lie> lies{
      {"columns and rows", [](auto& m) { m.source.frame.n_rows = 1; }},
      {"range of heights", [](auto& m) { m.source.range.lower = kNan; }},
      {"levels that get finer",
       [](auto& m) {
         m.hierarchy.tolerances = {20, 90};
       }},
      {"expected levels, got none", [](auto& m) { m.hierarchy.tolerances.clear(); }},
      {"at most 2^8 nodes", [](auto& m) { m.hierarchy.bits = 9; }},
      {"have 30 bits", [](auto& m) { m.source.frame.n_columns = 1 << 24; }},
      {"span a plane", [](auto& m) { m.source.frame.to_world = {0, 1e-160, 0, 0, 0, 1e-160}; }},
      {"a reach", [](auto& m) { m.hierarchy.reach = -1; }},
      {"a reach", [](auto& m) { m.hierarchy.reach = 17 << 8; }},
      {"vertices that get more", [](auto& m) { m.hierarchy.vertices_until[0] = 0; }},
      {"vertices that get more", [](auto& m) { m.hierarchy.vertices_until[0] = 10'000; }},
      {"triangles that get more", [](auto& m) { m.hierarchy.triangles_until[0] = 0; }},
      {"triangles that get more", [](auto& m) { m.hierarchy.triangles_until[1] = 1U << 30; }},
      {"more bytes", [](auto& m) { m.hierarchy.triangles_until.push_back(0); }},
      {"got only", [](auto& m) { ++m.hierarchy.vertices_until[1]; }},
      {"expected the end", [](auto& m) { --m.hierarchy.vertices_until[1]; }},
      {"got only", [](auto& m) { ++m.hierarchy.triangles_until[1]; }},
      {"expected a node", [](auto& m) { m.hierarchy.vertices[5].x = -1; }},
      {"expected a node", [](auto& m) { m.hierarchy.vertices[5].y = (12 << 8) + 1; }},
      {"expected a height", [](auto& m) { m.hierarchy.heights[5] = kNan; }},
      {"expected a height", [](auto& m) { m.hierarchy.heights[5] = 1e6; }},
      {"places of their own", [](auto& m) { m.hierarchy.vertices[5] = m.hierarchy.vertices[6]; }},
      {"expected vertices below",
       [](auto& m) { m.hierarchy.triangles[0].corner[0] = m.hierarchy.vertices_until[0]; }},
      {"turn left",
       [](auto& m) {
         std::swap(m.hierarchy.triangles[1].corner[0], m.hierarchy.triangles[1].corner[1]);
       }},
      {"turn left",
       [](auto& m) { m.hierarchy.triangles[1].corner[0] = m.hierarchy.triangles[1].corner[1]; }},
      {"finite error", [](auto& m) { m.hierarchy.triangles[2].error = -1; }},
      {"finite error", [](auto& m) { m.hierarchy.triangles[2].error = kInfinite; }},
      {"expected triangles within 90", [](auto& m) { m.hierarchy.triangles[0].error = 91; }},
      {"expected triangles within 20",
       [n](auto& m) { m.hierarchy.triangles[n - 1].error = 20.01F; }},
      {"a level before", [n](auto& m) { m.hierarchy.refinements[1].triangle = n - 1; }},
      {"that no other refines",
       [](auto& m) { m.hierarchy.refinements[1].triangle = m.hierarchy.refinements[0].triangle; }},
      {"expected from 2 triangles",
       [](auto& m) { m.hierarchy.refinements[1].first = m.hierarchy.refinements[0].first + 1; }},
      {"expected from 2 triangles",
       [](auto& m) { m.hierarchy.refinements[1].first = m.hierarchy.refinements[0].first - 7; }},
      {"triangles in all refinements",
       [](auto& m) { m.hierarchy.refinements.erase(m.hierarchy.refinements.begin()); }},
      {"line 0: expected two vertices", [](auto& m) { m.hierarchy.lines[0][1] = 0; }},
      {"line 1: expected two vertices",
       [](auto& m) { m.hierarchy.lines[1][0] = m.hierarchy.vertices_until[0]; }},
      // Two meet there on other ways than the refined one's neighbours do.
      {"along columns and rows",
       [](auto& m) {
         m.hierarchy.triangles[m.hierarchy.refinements.back().triangle].error = 0;
         m.hierarchy.refinements.pop_back();
       }},
      {"a triangle on each side",
       [](auto& m) { m.hierarchy.triangles[0].corner = m.hierarchy.triangles[1].corner; }}};
  for (const Lie& lie : lies) {
    HierarchyModel model = made;
    lie.tell(model);
    expect_refused(model, lie.why);
  }
}

TEST_F(hierarchy_file, refuses_meshes_that_are_none) {
  expect_refused(drawn({{0, 0}, {3, 0}, {3, 3}}, {{0, 1, 2}}), "along columns and rows");
  // A square, and one in it.
  expect_refused(drawn({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}},
                       {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}}),
                 "cover each place once");
  // Two squares on a side of a rectangle, which has no vertex there.
  expect_refused(drawn({{0, 0}, {2, 0}, {2, 1}, {0, 1}, {1, 1}, {0, 2}, {1, 2}, {2, 2}},
                       {{0, 1, 2}, {0, 2, 3}, {3, 4, 6}, {3, 6, 5}, {4, 2, 7}, {4, 7, 6}}),
                 "a crack");
  // Three triangles at one edge.
  expect_refused(drawn({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {2, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 4, 2}}),
                 "a triangle on each side, got 3");
  // A triangle whose refinement has a cell more.
  HierarchyModel wider = drawn({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}},
                               {{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {1, 4, 5}, {1, 5, 2}});
  wider.hierarchy.tolerances = {5, 2};
  wider.hierarchy.vertices_until = {6, 6};
  wider.hierarchy.triangles_until = {2, 5};
  wider.hierarchy.refinements = {{0, 2}};
  expect_refused(wider, "the outline of level 0");
  // What is well-formed is not.
  const HierarchyModel good =
      drawn({{0, 0}, {2, 0}, {2, 1}, {0, 1}, {1, 1}, {0, 2}, {1, 2}, {2, 2}},
            {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {3, 4, 6}, {3, 6, 5}, {4, 2, 7}, {4, 7, 6}});
  expect_same(saved_and_opened(good), saved_and_opened(good));
}

TEST_F(hierarchy_file, of_points_has_any_outline_that_goes_round_once) {
  expect_same(saved_and_opened(drawn_of_points({{0, 0}, {3, 1}, {2, 3}}, {{0, 1, 2}})),
              saved_and_opened(drawn_of_points({{0, 0}, {3, 1}, {2, 3}}, {{0, 1, 2}})));
  // Two that meet at a vertex, and four round a hole.
  saved_and_opened(
      drawn_of_points({{0, 0}, {3, 0}, {1, 1}, {3, 3}, {0, 2}}, {{0, 1, 2}, {2, 3, 4}}));
  saved_and_opened(drawn_of_points(
      {{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}},
      {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}}));
  // A square, and one in it; triangles that cross; one on a longer side of another.
  const char* why = "goes round what is inside once";
  expect_refused(drawn_of_points({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}},
                                 {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}}),
                 why);
  expect_refused(
      drawn_of_points({{0, 0}, {3, 1}, {0, 2}, {1, 0}, {2, 3}, {1, 3}}, {{0, 1, 2}, {3, 4, 5}}),
      why);
  expect_refused(
      drawn_of_points({{0, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 2}, {3, 0}}, {{0, 1, 2}, {3, 5, 4}}),
      why);
}

TEST_F(hierarchy_file, of_points_has_one_outline_at_all_levels) {
  // The third side through a vertex on it, and beside it.
  const std::vector<std::array<std::uint32_t, 3>> parts{{0, 1, 3}, {1, 2, 3}};
  HierarchyModel good = refined_of_points({{0, 0}, {3, 1}, {2, 2}, {1, 1}}, parts);
  good.hierarchy.crowded = {0};
  good.hierarchy.reach = 1;
  const HierarchyModel opened = saved_and_opened(good);
  EXPECT_TRUE(opened.hierarchy.is_of_points);
  EXPECT_EQ(opened.hierarchy.crowded, good.hierarchy.crowded);
  expect_refused(refined_of_points({{0, 0}, {3, 1}, {2, 3}, {1, 1}}, parts),
                 "level 1: expected the outline of level 0");
  expect_refused(refined_of_points({{0, 0}, {3, 1}, {2, 2}, {1, 2}}, parts),
                 "level 1: expected the outline of level 0");
  good.hierarchy.crowded = {0, 1};
  expect_refused(good, "up to 1 refined triangles with points beside them, got 2");
  good.hierarchy.crowded = {3};
  expect_refused(good, "points beside them that ascend, below 3, got 3");
  HierarchyModel raster = drawn({{0, 0}, {3, 0}, {3, 3}, {0, 3}}, {{0, 1, 2}, {0, 2, 3}});
  raster.hierarchy.crowded = {0};
  expect_refused(raster, "up to 0 refined triangles");
}

TEST_F(hierarchy_file, never_crashes_on_random_bytes) {
  oracles::Random random(3);
  const HeightGrid grid = test::make_grid<float>(12, 9, test::hills_with_spikes);
  for (const Kind kind : kKinds) {
    ASSERT_TRUE(save(build(kind, grid, {90, 20}), path_, progress_));
    const auto reader = store::Reader::open(path_);
    ASSERT_TRUE(reader);
    for (int trial = 0; trial < 25; ++trial) {
      const std::size_t victim = random.below(reader->blocks().size() + 1);
      const auto change = [&](std::size_t i, std::vector<std::byte> bytes) {
        if (i == victim) {
          bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 + random.below(255));
          if (trial % 5 == 0) bytes.resize(1 + random.below(bytes.size()));
        }
        return bytes;
      };
      auto writer = store::Writer::create(
          other_, reader->model(),
          change(reader->blocks().size(), {reader->metadata().begin(), reader->metadata().end()}));
      ASSERT_TRUE(writer);
      for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
        const std::vector<std::byte> bytes = change(i, *reader->read_block(i));
        ASSERT_TRUE(writer->append(reader->blocks()[i].key,
                                   store::encode_block({.raw = bytes, .size = 1})));
      }
      ASSERT_TRUE(writer->finish());
      const auto opened = open(other_, progress_);
      if (!opened) continue;
      const Hierarchy& h = opened->hierarchy;
      for (int level = 0; level < h.n_levels(); ++level)
        EXPECT_EQ(tin_of_level(h, level, delaunay::TinLinks::kept).triangles.size(),
                  h.n_triangles_in(level));
      static_cast<void>(n_out_of_reach(h));
    }
  }
}

}  // namespace
}  // namespace lode::hierarchy_file
