#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_check.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_file.h"
#include "tests/terrain/model_files.h"
#include "tests/terrain/pyramid_fixtures.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::Tin;
using delaunay::TinLinks;
using insertions::LevelledHistory;
using lode::test::rewrite;
using lode::test::ScratchFile;
using test::histories;
using test::history_of;
using test::kEncodings;
using test::meeting;
using test::pyramid_of;

void expect_same(const Tin& a, const Tin& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.heights, b.heights);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.twins, b.twins);
  EXPECT_EQ(a.errors, b.errors);
}

void expect_same(const Pyramid& a, const Pyramid& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.heights, b.heights);
  EXPECT_EQ(a.lines, b.lines);
  EXPECT_EQ(a.head.encoding, b.head.encoding);
  EXPECT_EQ(a.head.max_error, b.head.max_error);
  EXPECT_EQ(a.head.tolerances, b.head.tolerances);
  EXPECT_EQ(a.head.vertices_until, b.head.vertices_until);
  EXPECT_EQ(a.head.n_in_mesh, b.head.n_in_mesh);
  EXPECT_EQ(a.head.n_kept, b.head.n_kept);
  EXPECT_EQ(a.head.n_links, b.head.n_links);
  ASSERT_EQ(a.head.facts.size(), b.head.facts.size());
  for (std::size_t i = 0; i < a.head.facts.size(); ++i) {
    EXPECT_EQ(a.head.facts[i].largest_error, b.head.facts[i].largest_error);
    EXPECT_EQ(a.head.facts[i].smallest_angle, b.head.facts[i].smallest_angle);
    EXPECT_EQ(a.head.facts[i].median_angle, b.head.facts[i].median_angle);
  }
  EXPECT_EQ(a.head.source.frame.to_world, b.head.source.frame.to_world);
  EXPECT_EQ(a.head.source.sample_type, b.head.source.sample_type);
  EXPECT_EQ(a.head.source.n_missing, b.head.source.n_missing);
  ASSERT_EQ(a.levels.size(), b.levels.size());
  for (std::size_t level = 0; level < a.levels.size(); ++level) {
    EXPECT_EQ(a.levels[level].triangles, b.levels[level].triangles);
    EXPECT_EQ(a.levels[level].errors, b.levels[level].errors);
    EXPECT_EQ(a.levels[level].twins, b.levels[level].twins);
    EXPECT_EQ(a.levels[level].deaths, b.levels[level].deaths);
    EXPECT_EQ(a.levels[level].links.first, b.levels[level].links.first);
    EXPECT_EQ(a.levels[level].links.items, b.levels[level].links.items);
  }
}

TEST(pyramid_file, has_all_that_was_saved) {
  const ScratchFile file("pyramid.lode");
  for (const LevelledHistory& levelled : histories())
    for (const Encoding encoding : kEncodings) {
      Progress progress;
      const Pyramid made = pyramid_of(levelled, encoding);
      const auto size = save(made, file.path(), progress);
      ASSERT_TRUE(size) << size.error().message;
      EXPECT_EQ(*size, std::filesystem::file_size(file.path()));
      const auto opened = PyramidFile::open(file.path());
      ASSERT_TRUE(opened) << opened.error().message;
      EXPECT_LT(opened->stored_bytes().all(), *size);
      const auto read = opened->read_all(progress);
      ASSERT_TRUE(read) << read.error().message;
      expect_same(made, *read);
    }
}

TEST(pyramid_file, has_the_historys_mesh_at_each_level) {
  const ScratchFile file("levels.lode");
  for (const LevelledHistory& levelled : histories())
    for (const Encoding encoding : kEncodings) {
      Progress progress;
      const Pyramid made = pyramid_of(levelled, encoding);
      ASSERT_TRUE(save(made, file.path(), progress));
      const auto opened = PyramidFile::open(file.path());
      ASSERT_TRUE(opened) << opened.error().message;
      const auto times = times_of(levelled.history, levelled.levels);
      for (std::size_t level = 0; level < times.size(); ++level) {
        const Tin wanted = tin_at(levelled.history, times[level], TinLinks::kept);
        expect_same(tin_of_level(made, level, TinLinks::kept), wanted);
        const auto read = opened->read_mesh(level, progress);
        ASSERT_TRUE(read) << read.error().message;
        expect_same(tin_of_level(*read, level, TinLinks::kept), wanted);
      }
    }
}

/// Levels that nobody asks for are not read.
TEST(pyramid_file, reads_the_blocks_of_the_levels_that_a_mesh_takes) {
  const ScratchFile file("reads.lode");
  Progress progress;
  const LevelledHistory levelled = histories().front();
  for (const Encoding encoding : kEncodings) {
    const Pyramid made = pyramid_of(levelled, encoding);
    ASSERT_TRUE(save(made, file.path(), progress));
    const auto coarse = PyramidFile::open(file.path());
    const std::uint64_t n_opened = coarse->n_bytes_read();
    ASSERT_TRUE(coarse->read_mesh(2, progress));
    const auto whole = PyramidFile::open(file.path());
    ASSERT_TRUE(whole->read_all(progress));
    EXPECT_LT(coarse->n_bytes_read() - n_opened, (whole->n_bytes_read() - n_opened) / 4);
  }
}

/// Of meshes that are triangulations, but not Delaunay, and of lines that are none.
TEST(pyramid_file, is_held_for_being_delaunay_and_for_its_lines) {
  Progress progress;
  Pyramid turned = pyramid_of(history_of(insertions::test::cases()[0].grid), Encoding::lists);
  // The last level's mesh has an edge turned where the two triangles beside it make a convex quad.
  const auto place = [&](std::uint32_t v) { return turned.vertices[v]; };
  auto& list = turned.levels.back();
  const auto twins = delaunay::find_twins(list.triangles);
  bool is_done = false;
  for (std::size_t t = 0; t < twins.size() && !is_done; ++t)
    for (std::size_t i = 0; i < 3 && !is_done; ++i) {
      if (twins[t][i] == delaunay::kNoHalfEdge) continue;
      auto& one = list.triangles[t];
      auto& two = list.triangles[twins[t][i] / 4];
      const std::size_t j = twins[t][i] % 4;
      const std::uint32_t a = one[i];
      const std::uint32_t b = one[(i + 1) % 3];
      const std::uint32_t c = one[(i + 2) % 3];
      const std::uint32_t d = two[(j + 2) % 3];
      if (delaunay::doubled_area(place(a), place(d), place(c)) <= 0 ||
          delaunay::doubled_area(place(d), place(b), place(c)) <= 0 ||
          !delaunay::is_in_circle(place(a), place(d), place(c), place(b)))
        continue;
      one = {a, d, c};
      two = {d, b, c};
      is_done = true;
    }
  ASSERT_TRUE(is_done);
  EXPECT_EQ(find_faults(turned, progress)->n_other_levels, 1U);
  turned.head.facts[3].median_angle /= 2;
  EXPECT_GE(find_faults(turned, progress)->n_other_angles, 1U);
  Pyramid lined = pyramid_of(histories().back(), Encoding::complete);
  ASSERT_EQ(lined.lines.size(), 1U);
  lined.lines[0][1] = lined.lines[0][0] == 0 ? 1 : 0;
  EXPECT_EQ(find_faults(lined, progress)->n_line_levels, lined.head.n_levels());
}

void expect_refused(const std::string& path, const std::string& why) {
  Progress progress;
  const auto opened = PyramidFile::open(path);
  const auto read = opened ? opened->read_all(progress) : Result<Pyramid>(opened.error());
  ASSERT_FALSE(read);
  const std::string& message = read.error().message;
  EXPECT_NE(message.find(path), std::string::npos) << message;
  EXPECT_NE(message.find(why), std::string::npos) << message;
}

class pyramid_lies : public testing::Test {
 protected:
  void expect(Encoding encoding, const char* why, const std::function<void(Pyramid&)>& change) {
    SCOPED_TRACE(why);
    Pyramid lie = pyramid_of(histories()[1], encoding);
    change(lie);
    Progress progress;
    ASSERT_TRUE(save(lie, file_.path(), progress));
    expect_refused(file_.path(), why);
  }
  void expect_of_all(const char* why, const std::function<void(Pyramid&)>& change) {
    for (const Encoding encoding : kEncodings) expect(encoding, why, change);
  }

  const ScratchFile file_{"pyramid_lie.lode"};
};

TEST_F(pyramid_lies, of_the_metadata_are_named) {
  expect_of_all("expected levels", [](Pyramid& p) {
    p.head.tolerances.assign(1, -1);
    p.head.vertices_until.resize(1);
    p.head.facts.resize(1);
    p.levels.resize(1);
  });
  expect_of_all("error from 0", [](Pyramid& p) { p.head.max_error = 2.5; });
  expect_of_all("error from 0", [](Pyramid& p) { p.head.max_error = std::nan(""); });
  expect_of_all("of from 3", [](Pyramid& p) { p.head.vertices_until[0] = 2; });
  expect_of_all("level 0: expected triangles", [](Pyramid& p) { p.head.n_in_mesh[0] = 0; });
  expect_of_all("level 3: expected triangles", [](Pyramid& p) { p.head.n_in_mesh[3] = 1 << 29; });
  expect_of_all("level 8: expected no links", [](Pyramid& p) { p.head.n_links[8] = 1; });
  expect(Encoding::lists, "level 3: expected no links", [](Pyramid& p) { p.head.n_links[3] = 1; });
  expect(Encoding::complete, "level 2: expected up to",
         [](Pyramid& p) { p.head.n_links[2] = ~0ULL; });
  expect(Encoding::linked_lists, "level 2: expected up to",
         [](Pyramid& p) { p.head.n_links[2] = std::uint64_t{1} << 50; });
  expect_of_all("an error up to", [](Pyramid& p) { p.head.facts[8].largest_error = 2.125; });
  expect_of_all("smallest angles", [](Pyramid& p) { p.head.facts[8].smallest_angle = 61; });
  expect_of_all("largest error is 1", [](Pyramid& p) { p.head.facts[8].largest_error = 1; });
  expect_of_all("up to 0 lines", [](Pyramid& p) { p.head.n_lines = 1; });
}

TEST_F(pyramid_lies, of_vertices_and_triangles_are_named) {
  expect_of_all("level 0: expected vertices in", [](Pyramid& p) { p.vertices[0].x = 37; });
  expect_of_all("places of their own", [](Pyramid& p) { p.vertices[1] = p.vertices[0]; });
  expect_of_all("expected heights from", [](Pyramid& p) { p.heights[3] = 32000; });
  expect_of_all("expected one of", [](Pyramid& p) { p.levels[2].triangles[0][1] = 1'000'000; });
  expect_of_all("turn left", [](Pyramid& p) {
    std::swap(p.levels[2].triangles[0][1], p.levels[2].triangles[0][2]);
  });
  for (const float error : {-1.0F, std::numeric_limits<float>::infinity()})
    expect_of_all("expected finite errors", [&](Pyramid& p) { p.levels[2].errors[0] = error; });
  expect_of_all("largest error", [](Pyramid& p) { p.levels[8].errors[0] = 2.125F; });
  expect_of_all("covers its domain once",
                [](Pyramid& p) { p.levels[8].triangles[20] = p.levels[8].triangles[21]; });
  expect_of_all("level 4: expected a mesh of", [](Pyramid& p) { ++p.head.vertices_until[4]; });
  expect(Encoding::complete, "neighbours",
         [](Pyramid& p) { std::swap(p.levels[4].twins[0][0], p.levels[4].twins[0][1]); });
  expect(Encoding::complete, "neighbours",
         [](Pyramid& p) { p.levels[4].twins[3][0] = 0xFFFFFFFEU; });
}

TEST_F(pyramid_lies, of_deaths_and_links_are_named) {
  for (const Encoding encoding : {Encoding::lists, Encoding::linked_lists}) {
    expect(encoding, "end with a level from 3 to 9", [](Pyramid& p) { p.levels[2].deaths[0] = 2; });
    expect(encoding, "end with a level from 3 to 9",
           [](Pyramid& p) { p.levels[2].deaths[0] = 10; });
  }
  expect(Encoding::lists, "expected a mesh of", [](Pyramid& p) {
    std::uint32_t& death = p.levels[2].deaths[0];
    death = death == 9 ? 8 : 9;
  });
  for (const Encoding encoding : {Encoding::complete, Encoding::linked_lists}) {
    expect(encoding, "links that ascend", [](Pyramid& p) { p.levels[3].links.items[0] = 1 << 28; });
    expect(encoding, "links that ascend", [](Pyramid& p) {
      LinkLists& links = p.levels[3].links;
      std::uint32_t t = 0;
      while (links.of(t).size() < 2) ++t;
      links.items[links.first[t]] = links.items[links.first[t] + 1];
    });
    expect(encoding, "links to one or more", [](Pyramid& p) {
      // All of one's are the next one's.
      LinkLists& links = p.levels[3].links;
      std::uint32_t t = 0;
      while (links.of(t).empty()) ++t;
      links.first[t + 1] = links.first[t];
    });
    expect(encoding, "no links to any", [](Pyramid& p) {
      p.levels.back().links.first.back() = 1;
      p.levels.back().links.items.assign(1, 0);
    });
  }
}

TEST_F(pyramid_lies, of_points_are_named) {
  const auto expect_of_points = [&](const char* why, const std::function<void(Pyramid&)>& change) {
    for (const Encoding encoding : kEncodings) {
      SCOPED_TRACE(why);
      Pyramid lie = pyramid_of(histories().back(), encoding);
      change(lie);
      Progress progress;
      ASSERT_TRUE(save(lie, file_.path(), progress));
      expect_refused(file_.path(), why);
    }
  };
  expect_of_points("expected lines between",
                   [](Pyramid& p) { p.lines[0][1] = p.head.vertices_until[0]; });
  expect_of_points("expected lines between",
                   [](Pyramid& p) { std::swap(p.lines[0][0], p.lines[0][1]); });
  expect_of_points("expected lines between", [](Pyramid& p) {
    p.lines.push_back(p.lines[0]);
    p.head.n_lines = 2;
  });
  expect_of_points("covers its domain once",
                   [](Pyramid& p) { p.levels[2].triangles[0] = p.levels[2].triangles[1]; });
}

/// The outline of another level's mesh: without the triangles at its vertex.
TEST_F(pyramid_lies, of_a_domain_that_changes_are_named) {
  const HeightGrid grid = delaunay::test::make_grid<float>(
      9, 9, [](int x, int y) { return x == 4 && y == 4 ? 50 : 0; });
  LevelledHistory levelled = history_of(grid);
  levelled.levels = {100, 2};
  Pyramid lie = pyramid_of(levelled, Encoding::complete);
  PyramidLevel& fine = lie.levels[1];
  // Two squares of the fine mesh's vertices that are in all others, too, do not go on.
  ASSERT_EQ(lie.head.n_in_mesh[0], 2U);
  fine.triangles.clear();
  fine.errors.clear();
  lie.vertices = {lie.vertices[0], lie.vertices[1], lie.vertices[2],
                  lie.vertices[3], {4, 0},          {4, 8}};
  std::ranges::sort(lie.vertices.begin(), lie.vertices.begin() + 4, {},
                    [](delaunay::LatticePoint p) { return std::pair(p.y, p.x); });
  lie.heights.assign(6, 0);
  lie.levels[0].triangles = {{0, 1, 3}, {0, 3, 2}};
  lie.levels[0].twins = delaunay::find_twins(lie.levels[0].triangles);
  fine.triangles = {{0, 4, 5}, {0, 5, 2}, {4, 1, 3}, {4, 3, 5}};
  fine.errors.assign(4, 0);
  fine.twins = delaunay::find_twins(fine.triangles);
  lie.head.vertices_until = {4, 6};
  lie.head.facts[0].largest_error = static_cast<double>(std::ranges::max(lie.levels[0].errors));
  lie.head.facts[1].largest_error = 0;
  const auto save_with_links = [&] {
    for (PyramidLevel& level : lie.levels) level.links = {};
    auto& links = lie.levels[0].links;
    for (const auto& corner : lie.levels[0].triangles) {
      if (links.first.empty()) links.first.push_back(0);
      const auto all = meeting(lie, corner, fine);
      links.items.insert(links.items.end(), all.begin(), all.end());
      links.first.push_back(links.items.size());
    }
    fine.links.first.assign(fine.triangles.size() + 1, 0);
    for (std::size_t i = 0; i < 2; ++i)
      lie.head.n_in_mesh[i] = lie.head.n_kept[i] =
          static_cast<std::uint32_t>(lie.levels[i].triangles.size());
    lie.head.n_links = {links.items.size(), 0};
    Progress progress;
    ASSERT_TRUE(save(lie, file_.path(), progress));
  };
  save_with_links();
  Progress progress;
  const auto honest = PyramidFile::open(file_.path());
  ASSERT_TRUE(honest) << honest.error().message;
  const auto read = honest->read_all(progress);
  EXPECT_TRUE(read) << read.error().message;
  // A notch: a vertex on the upper side comes down.
  lie.vertices[5] = {4, 4};
  fine.triangles = {{0, 4, 5}, {0, 5, 2}, {4, 1, 5}, {1, 3, 5}};
  fine.twins = delaunay::find_twins(fine.triangles);
  lie.head.source.is_of_points = true;
  save_with_links();
  expect_refused(file_.path(), "level 1: expected the outline of all levels");
}

/// Each byte counts, and so does each that is missing.
TEST(pyramid_lies_of_bytes, are_seen_wherever_they_are_in_a_file) {
  const ScratchFile whole("pyramid_small.lode");
  const ScratchFile lie("pyramid_changed.lode");
  Progress progress;
  LevelledHistory levelled =
      history_of(delaunay::test::make_grid<std::int16_t>(4, 3, insertions::test::terrain));
  levelled.levels = {400, 2};
  for (const Encoding encoding : kEncodings) {
    ASSERT_TRUE(save(pyramid_of(levelled, encoding), whole.path(), progress));
    std::ifstream stream(whole.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    const auto is_read = [&](const std::string& changed) {
      std::ofstream(lie.path(), std::ios::binary) << changed;
      const auto opened = PyramidFile::open(lie.path());
      return opened && opened->read_all(progress);
    };
    EXPECT_TRUE(is_read(bytes));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      std::string changed = bytes;
      changed[i] = static_cast<char>(changed[i] ^ (1 << i % 8));
      EXPECT_FALSE(is_read(changed)) << i;
      if (i % 4 == 0) EXPECT_FALSE(is_read(bytes.substr(0, i))) << i;
    }
  }
}

/// Whatever blocks hold, what is read is a triangulation at each level.
TEST(pyramid_lies_of_bytes, never_make_meshes_that_are_none) {
  const ScratchFile whole("pyramid_honest.lode");
  const ScratchFile lie("pyramid_random.lode");
  Progress progress;
  oracles::Random random(11);
  int n_refused = 0;
  const auto all = histories();
  constexpr int kTrials = 50;
  for (int trial = 0; trial < 6 * kTrials; ++trial) {
    const auto kind = static_cast<std::size_t>(trial / kTrials);
    if (trial % kTrials == 0)
      ASSERT_TRUE(save(pyramid_of(kind < 3 ? all[1] : all.back(), kEncodings[kind % 3]),
                       whole.path(), progress));
    const std::size_t victim = random.below(11);
    rewrite(whole.path(), lie.path(),
            [&](std::uint32_t column, std::uint32_t, std::vector<std::byte>& bytes) {
              if (column != victim || random.below(3) != 0 || bytes.empty()) return;
              bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 << random.below(8));
              if (trial % 7 == 0) bytes.resize(1 + random.below(bytes.size()));
            });
    const auto opened = PyramidFile::open(lie.path());
    const auto read = opened ? opened->read_all(progress) : Result<Pyramid>(opened.error());
    if (!read) {
      ++n_refused;
      EXPECT_NE(read.error().message.find(lie.path()), std::string::npos) << read.error().message;
      continue;
    }
    std::int64_t area = 0;
    for (std::size_t level = 0; level < read->head.n_levels(); ++level) {
      const Tin tin = tin_of_level(*read, level, TinLinks::kept);
      std::int64_t sum = 0;
      for (const auto& [a, b, c] : tin.triangles) {
        const std::int64_t own =
            delaunay::doubled_area(tin.vertices[a], tin.vertices[b], tin.vertices[c]);
        EXPECT_GT(own, 0);
        sum += own;
      }
      if (level == 0) area = sum;
      EXPECT_EQ(sum, area);
    }
    EXPECT_TRUE(find_faults(*read, progress));
  }
  EXPECT_GT(n_refused, 80);
}

}  // namespace
}  // namespace lode::delaunay_pyramid
