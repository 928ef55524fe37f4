#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lode/delaunay/tin_links.h"
#include "lode/locate/tin_profile.h"
#include "lode/models/terrain/delaunay_pyramid/link_search.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_check.h"
#include "lode/models/terrain/insertions/place_tests.h"
#include "tests/terrain/model_files.h"
#include "tests/terrain/pyramid_fixtures.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticeCorners;
using delaunay::Point;
using delaunay::Tin;
using delaunay::TinLinks;
using lode::test::rewrite;
using lode::test::ScratchFile;
using test::histories;
using test::kEncodings;
using test::LevelledHistory;
using test::meeting;
using test::pyramid_of;

constexpr std::array kLinked{Encoding::complete, Encoding::linked_lists};

TEST(pyramid_links, are_to_all_that_meets_in_the_level_that_they_lead_to) {
  for (const LevelledHistory& levelled : histories())
    for (const Encoding encoding : {Encoding::complete, Encoding::linked_lists}) {
      const Pyramid made = pyramid_of(levelled, encoding);
      for (std::size_t level = 0; level < made.levels.size(); ++level) {
        const PyramidLevel& kept = made.levels[level];
        for (std::uint32_t t = 0; t < kept.triangles.size(); ++t) {
          const std::size_t to = made.head.is_of_lists() ? kept.deaths[t] : level + 1;
          const auto links = kept.links.of(t);
          if (to == made.levels.size()) {
            EXPECT_TRUE(links.empty());
            continue;
          }
          EXPECT_EQ(std::vector(links.begin(), links.end()),
                    meeting(made, kept.triangles[t], made.levels[to]));
        }
      }
      Progress progress;
      const auto faults = find_faults(made, progress);
      ASSERT_TRUE(faults);
      EXPECT_EQ(faults->n_links, made.head.n_all_links());
      EXPECT_EQ(faults->n_wrong_owners, 0U);
      EXPECT_EQ(faults->n_line_levels, 0U);
      EXPECT_EQ(faults->n_other_angles, 0U);
      EXPECT_EQ(faults->n_other_levels, 0U);
    }
}

TEST(pyramid_links, that_are_wrong_are_found) {
  Progress progress;
  const LevelledHistory levelled = histories().front();
  for (const Encoding encoding : {Encoding::complete, Encoding::linked_lists}) {
    const Pyramid made = pyramid_of(levelled, encoding);
    // Of the first with two, each in turn is another one, which is free.
    for (std::size_t at = 0; at < 2; ++at) {
      Pyramid lie = made;
      LinkLists& links = lie.levels[2].links;
      std::uint32_t t = 0;
      while (links.of(t).size() != 2) ++t;
      std::uint32_t other = 0;
      while (std::ranges::count(links.of(t), other) > 0) ++other;
      links.items[links.first[t] + at] = other;
      EXPECT_EQ(find_faults(lie, progress)->n_wrong_owners, 1U);
    }
  }
}

TEST(pyramid_links, are_refused_beyond_their_memory) {
  Progress progress;
  const LevelledHistory levelled = histories().front();
  for (const Encoding encoding : kEncodings) {
    const auto made =
        encode(levelled.history, levelled.levels, encoding, {.n_bytes = 1000}, progress);
    EXPECT_EQ(made.has_value(), encoding == Encoding::lists);
    if (!made) EXPECT_NE(made.error().message.find("1000 bytes"), std::string::npos);
  }
}

/// Of a mesh the triangles that wanted(corners), as a TIN of their own.
Tin part_of(const Tin& tin, const std::function<bool(const LatticeCorners&)>& wanted) {
  Tin part;
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    const auto& [a, b, c] = tin.triangles[t];
    if (!wanted({tin.vertices[a], tin.vertices[b], tin.vertices[c]})) continue;
    part.triangles.push_back(tin.triangles[t]);
    part.errors.push_back(tin.errors[t]);
  }
  insertions::place_vertices(tin.vertices, tin.heights, part);
  part.twins = delaunay::find_twins(part.triangles);
  return part;
}

void expect_same_part(const Result<Tin>& found, const Tin& wanted) {
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->vertices, wanted.vertices);
  EXPECT_EQ(found->heights, wanted.heights);
  EXPECT_EQ(found->triangles, wanted.triangles);
  EXPECT_EQ(found->errors, wanted.errors);
  EXPECT_EQ(found->twins, wanted.twins);
}

/// In triangles, on edges and vertices, in gaps and outside.
std::vector<Point> places_in(const HeightFrame& frame, oracles::Random& random) {
  std::vector<Point> places;
  const double width = frame.n_columns - 1;
  const double height = frame.n_rows - 1;
  for (int i = 0; i < 12; ++i)
    places.push_back({{random.uniform() * width, random.uniform() * height}});
  for (int i = 0; i < 12; ++i)
    places.push_back(
        {{std::floor(random.uniform() * width), std::floor(random.uniform() * height)}});
  places.push_back({{-1, 0.5}});
  places.push_back({{width, height}});
  return places;
}

TEST(pyramid_links, lead_to_what_holds_places_and_to_what_ways_meet) {
  const ScratchFile file("linked.lode");
  oracles::Random random(21);
  for (const LevelledHistory& levelled : histories())
    for (const Encoding encoding : kLinked) {
      Progress progress;
      const Pyramid made = pyramid_of(levelled, encoding);
      ASSERT_TRUE(save(made, file.path(), progress));
      const auto opened = PyramidFile::open(file.path());
      ASSERT_TRUE(opened);
      const auto start = LinkStart::read(*opened, progress);
      ASSERT_TRUE(start);
      for (std::size_t level = 0; level < made.levels.size(); ++level) {
        const Tin whole = tin_of_level(made, level, TinLinks::kept);
        const std::vector<Point> places = places_in(made.head.source.frame, random);
        expect_same_part(tin_around(*opened, *start, level, places, progress),
                         part_of(whole, [&](const LatticeCorners& corners) {
                           return std::ranges::any_of(places, [&](const Point& p) {
                             return insertions::holds_place(corners, p);
                           });
                         }));
        const auto box = insertions::box_round(places[0], places[1]);
        expect_same_part(tin_along(*opened, *start, level, places[0], places[1], progress),
                         part_of(whole, [&](const LatticeCorners& corners) {
                           return insertions::box_of(corners).meets(box) &&
                                  !insertions::is_beside_line(corners, places[0], places[1]);
                         }));
      }
    }
}

TEST(pyramid_links, that_lead_nowhere_are_named_by_who_follows_them) {
  const ScratchFile file("nowhere.lode");
  Progress progress;
  const LevelledHistory levelled = histories().front();
  for (const Encoding encoding : kLinked) {
    // Of each triangle of level 2 that is split, the links are to the first triangle it may be
    // linked to alone.
    Pyramid lie = pyramid_of(levelled, encoding);
    LinkLists& links = lie.levels[2].links;
    LinkLists others;
    others.first.push_back(0);
    for (std::uint32_t t = 0; t < lie.levels[2].triangles.size(); ++t) {
      if (!links.of(t).empty()) others.items.push_back(0);
      others.first.push_back(others.items.size());
    }
    links = others;
    lie.head.n_links[2] = links.items.size();
    ASSERT_TRUE(save(lie, file.path(), progress));
    const auto opened = PyramidFile::open(file.path());
    ASSERT_TRUE(opened) << opened.error().message;
    const auto start = LinkStart::read(*opened, progress);
    ASSERT_TRUE(start);
    std::vector<Point> places;
    for (int x = 0; x < 39; ++x) places.push_back({{x + 0.3, 20.1}});
    const auto found = tin_around(*opened, *start, 6, places, progress);
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().message.find(file.path() + ": level 2: triangle"), std::string::npos)
        << found.error().message;
    EXPECT_TRUE(tin_around(*opened, *start, 2, places, progress));
  }
}

/// Whatever blocks hold, what is found is parts of a mesh, to be asked.
TEST(pyramid_links, of_any_bytes_lead_to_parts_of_a_mesh_or_to_an_error) {
  const ScratchFile whole("links_honest.lode");
  const ScratchFile lie("links_random.lode");
  Progress progress;
  oracles::Random random(13);
  int n_refused = 0;
  int n_found = 0;
  const auto all = histories();
  constexpr int kTrials = 50;
  for (int trial = 0; trial < 4 * kTrials; ++trial) {
    const auto kind = static_cast<std::size_t>(trial / kTrials);
    if (trial % kTrials == 0)
      ASSERT_TRUE(save(pyramid_of(kind < 2 ? all[1] : all.back(), kLinked[kind % 2]), whole.path(),
                       progress));
    const std::size_t victim = 1 + random.below(10);
    rewrite(whole.path(), lie.path(),
            [&](std::uint32_t column, std::uint32_t, std::vector<std::byte>& bytes) {
              if (column != victim || bytes.empty()) return;
              for (int i = 0; i < 3; ++i)
                bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 << random.below(8));
            });
    const auto opened = PyramidFile::open(lie.path());
    ASSERT_TRUE(opened) << opened.error().message;
    const auto start = LinkStart::read(*opened, progress);
    if (!start) continue;
    const std::vector<Point> places = places_in(opened->head().source.frame, random);
    for (std::size_t level = 0; level < opened->head().n_levels(); ++level) {
      const auto around = tin_around(*opened, *start, level, places, progress);
      const auto along = tin_along(*opened, *start, level, places[0], places[1], progress);
      if (along) (void)tin_profile(*along, places[0], places[1]);
      (around ? n_found : n_refused) += 1;
      if (!around) EXPECT_NE(around.error().message.find(lie.path()), std::string::npos);
    }
  }
  EXPECT_GT(n_refused, 100);
  EXPECT_GT(n_found, 100);
}

}  // namespace
}  // namespace lode::delaunay_pyramid
