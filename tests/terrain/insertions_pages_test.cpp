#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice_side.h"
#include "lode/locate/tin_profile.h"
#include "lode/models/terrain/insertions/death_finder.h"
#include "lode/models/terrain/insertions/history_file.h"
#include "lode/models/terrain/insertions/local_lines.h"
#include "lode/models/terrain/insertions/local_selection.h"
#include "lode/models/terrain/insertions/mesh_replay.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/models/terrain/insertions/replay.h"
#include "tests/oracles/random.h"
#include "tests/terrain/insertions_fixtures.h"

namespace lode::insertions {
namespace {

using delaunay::Tin;
using delaunay::TinLinks;

/// Histories of all models, of rasters and points, and their files.
class insertions_pages : public testing::Test {
 protected:
  insertions_pages()
      : path_(testing::TempDir() + "lode_pages_" + std::to_string(::getpid()) + ".lode") {}
  ~insertions_pages() override { std::filesystem::remove(path_); }

  /// check(levelled, file) of each.
  template <typename Check>
  void for_each(const Check& check) {
    for (const Model model : test::kModels) {
      for (test::Case& one : test::cases()) {
        SCOPED_TRACE(one.name + std::string(" ") + std::string(model_name(model)));
        run({test::history_of(one.grid, 2, model), {}}, check);
      }
      SCOPED_TRACE("points " + std::string(model_name(model)));
      if (model != Model::implicit_delaunay_pyramid) run(test::make_point_model(model), check);
    }
  }

  /// With small pages, too, so that there are many.
  template <typename Check>
  void run(const LevelledHistory& made, const Check& check) {
    for (const std::uint32_t n : {12U, 1024U}) {
      const auto size = save(made, path_, progress_, {.n_nodes = n});
      ASSERT_TRUE(size) << size.error().message;
      const auto file = HistoryFile::open(path_);
      ASSERT_TRUE(file) << file.error().message;
      check(made, *file);
    }
  }

  std::string path_;
  Progress progress_;
};

void expect_same(const Tin& a, const Tin& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.heights, b.heights);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.errors, b.errors);
  EXPECT_EQ(a.twins, b.twins);
}

TEST_F(insertions_pages, tell_what_removes_each_triangle) {
  for_each([](const LevelledHistory& made, const HistoryFile& file) {
    OpenPages pages(file);
    DeathFinder deaths(pages);
    const History& history = made.history;
    for (std::uint32_t t = 0; t < history.triangles.size(); ++t) {
      const auto& [a, b, c] = history.triangles[t].corner;
      const auto death =
          deaths.find({history.vertices[a], history.vertices[b], history.vertices[c]},
                      history.birth(t) == kNone ? 0 : history.birth(t) + 1, history.n_nodes());
      ASSERT_TRUE(death) << death.error().message;
      ASSERT_EQ(death->time, history.triangles[t].death) << t;
    }
  });
}

TEST_F(insertions_pages, replay_to_where_a_band_ends) {
  for_each([&](const LevelledHistory& made, const HistoryFile& file) {
    for (std::size_t n = 0; n <= file.bands().size(); ++n) {
      const auto history = replay(file, n, progress_);
      ASSERT_TRUE(history) << history.error().message;
      ASSERT_EQ(history->n_nodes(), n == 0 ? 0 : file.bands()[n - 1].end);
      for (const std::uint32_t time : {history->n_nodes() / 3, history->n_nodes()})
        expect_same(tin_at(*history, time, TinLinks::kept),
                    tin_at(made.history, time, TinLinks::kept));
    }
  });
}

TEST_F(insertions_pages, have_the_mesh_of_any_time_square_by_square) {
  for_each([&](const LevelledHistory& made, const HistoryFile& file) {
    for (const std::uint32_t time :
         {0U, 1U, file.n_nodes() / 3, file.n_nodes() - 1, file.n_nodes()})
      for (const std::size_t n : {std::size_t{2}, std::size_t{9}, kNodesInSquare}) {
        const auto tin = tin_at(file, std::min(time, file.n_nodes()), progress_, n);
        ASSERT_TRUE(tin) << tin.error().message;
        expect_same(*tin, tin_at(made.history, std::min(time, file.n_nodes()), TinLinks::kept));
      }
  });
}

TEST_F(insertions_pages, know_the_mesh_of_each_tolerance) {
  for_each([](const LevelledHistory& made, const HistoryFile& file) {
    const History& history = made.history;
    if (!history.is_worst_first()) return;
    for (const double tolerance : {1e9, 700.0, 200.0, 60.0, 20.0, 6.5, 2.0, 0.5, 0.0}) {
      const ToleranceStep& step = step_within(file.steps(), tolerance);
      EXPECT_EQ(step.time, time_within(history, tolerance));
      const Tin tin = tin_at(history, step.time, TinLinks::kept);
      EXPECT_EQ(step.n_triangles, tin.triangles.size());
      EXPECT_EQ(step.largest, *std::ranges::max_element(tin.errors));
    }
    EXPECT_EQ(file.n_history_bytes(), history.n_bytes());
  });
}

TEST_F(insertions_pages, have_the_mesh_of_any_demand) {
  for_each([&](const LevelledHistory& made, const HistoryFile& file) {
    for (const Demand& demand :
         {test::box_demand(0, 1e9), test::box_demand(5, 90), test::box_demand(90, 5),
          uniform_demand(40), uniform_demand(0), uniform_demand(1e9)}) {
      const auto tin = select_tin(file, demand, TinLinks::kept, file.n_nodes(), progress_);
      ASSERT_TRUE(tin) << tin.error().message;
      ASSERT_TRUE(*tin);
      expect_same(**tin, tin_of(made.history, select_nodes(made.history, demand), TinLinks::kept));
    }
  });
}

/// The triangles of a TIN that are, renumbered, those of another one.
void expect_part(const Tin& part, const Tin& whole) {
  std::size_t at = 0;
  for (std::size_t t = 0; t < part.triangles.size(); ++t, ++at) {
    const auto places = [](const Tin& tin, std::size_t i) {
      const auto& [a, b, c] = tin.triangles[i];
      return std::array{tin.vertices[a], tin.vertices[b], tin.vertices[c]};
    };
    while (at < whole.triangles.size() && places(whole, at) != places(part, t)) ++at;
    ASSERT_LT(at, whole.triangles.size());
    EXPECT_EQ(part.errors[t], whole.errors[at]);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(part.heights[part.triangles[t][i]], whole.heights[whole.triangles[at][i]]);
  }
}

bool holds_place(const Tin& tin, std::size_t t, const delaunay::Point& p) {
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::side_of(tin.vertices[tin.triangles[t][i]],
                          tin.vertices[tin.triangles[t][(i + 1) % 3]], p) < 0)
      return false;
  return true;
}

TEST_F(insertions_pages, have_all_triangles_round_places) {
  oracles::Random random(9);
  for_each([&](const LevelledHistory& made, const HistoryFile& file) {
    const History& history = made.history;
    std::vector<delaunay::Point> places;
    for (int i = 0; i < 12; ++i) {
      // Nodes, middles of edges, and any.
      const double step = i % 3 == 0 ? 1 : i % 3 == 1 ? 0.5 : 0.01;
      const auto along = [&](std::int32_t n) {
        return step * static_cast<double>(random.below(static_cast<std::uint64_t>(n / step)));
      };
      places.push_back({{along(history.frame.n_columns), along(history.frame.n_rows)}});
    }
    for (const std::uint32_t time : {history.n_nodes() / 3, history.n_nodes()}) {
      const Tin whole = tin_at(history, time, TinLinks::kept);
      const auto part = tin_around(file, time, places, progress_);
      ASSERT_TRUE(part) << part.error().message;
      expect_part(*part, whole);
      std::size_t n_holders = 0;
      for (std::size_t t = 0; t < whole.triangles.size(); ++t)
        n_holders += std::ranges::any_of(
            places, [&](const delaunay::Point& p) { return holds_place(whole, t, p); });
      EXPECT_EQ(part->triangles.size(), n_holders);
    }
  });
}

TEST_F(insertions_pages, have_the_same_profile_along_a_line) {
  for_each([&](const LevelledHistory& made, const HistoryFile& file) {
    const History& history = made.history;
    const double width = history.frame.n_columns - 1;
    const double height = history.frame.n_rows - 1;
    for (const auto& [a, b] :
         {std::pair<delaunay::Point, delaunay::Point>{{{-3.5, 0.25}}, {{width, height}}},
          {{{0, 0}}, {{width, 0}}},
          {{{0, 0.5 * height}}, {{width + 9, 0.5 * height}}},
          {{{0.25 * width, 0}}, {{0.3 * width, height}}}})
      for (const std::uint32_t time : {history.n_nodes() / 3, history.n_nodes()}) {
        const auto part = tin_along(file, time, a, b, progress_);
        ASSERT_TRUE(part) << part.error().message;
        const auto want = tin_profile(tin_at(history, time, TinLinks::kept), a, b);
        const auto got = tin_profile(*part, a, b);
        ASSERT_EQ(got.size(), want.size());
        for (std::size_t i = 0; i < got.size(); ++i) {
          EXPECT_EQ(got[i].t, want[i].t);
          EXPECT_EQ(got[i].height, want[i].height);
          EXPECT_EQ(got[i].rounding, want[i].rounding);
          EXPECT_EQ(got[i].error, want[i].error);
          EXPECT_EQ(got[i].starts_part, want[i].starts_part);
        }
      }
  });
}

std::size_t count_crossing(const Tin& tin, std::span<const double> heights) {
  return static_cast<std::size_t>(std::ranges::count_if(tin.triangles, [&](const auto& corner) {
    const auto [low, high] =
        std::minmax({tin.heights[corner[0]], tin.heights[corner[1]], tin.heights[corner[2]]});
    return std::ranges::any_of(heights, [&](double z) { return low <= z && z <= high; });
  }));
}

TEST_F(insertions_pages, have_all_triangles_that_heights_cross) {
  oracles::Random random(13);
  for_each([&](const LevelledHistory& made, const HistoryFile& file) {
    const History& history = made.history;
    if (!history.is_worst_first()) return;
    for (const std::uint32_t time : {0U, history.n_nodes() / 3, history.n_nodes()}) {
      const Tin whole = tin_at(history, time, TinLinks::kept);
      const auto [lowest, highest] = std::ranges::minmax(whole.heights);
      const auto range = height_range(file, time, kNone, progress_);
      ASSERT_TRUE(range && *range);
      EXPECT_EQ((*range)->lower, lowest);
      EXPECT_EQ((*range)->upper, highest);
      // At a vertex, at a sample that there may be no vertex of, between, and several.
      const double vertex = whole.heights[random.below(whole.heights.size())];
      const double sample = history.heights[random.below(history.heights.size())];
      for (std::vector<double> heights : {std::vector{vertex},
                                          {sample},
                                          {0.7 * lowest + 0.3 * highest},
                                          {lowest},
                                          {highest},
                                          {highest + 1},
                                          {lowest, vertex + 0.25, highest - 0.125}}) {
        std::ranges::sort(heights);
        heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
        const auto part = tin_crossing(file, time, heights, kNone, progress_);
        ASSERT_TRUE(part && *part);
        expect_part(**part, whole);
        EXPECT_EQ(count_crossing(**part, heights), count_crossing(whole, heights));
        const double expected = expected_crossing(file, time, heights);
        EXPECT_GE(expected, 0);
        EXPECT_LE(expected, time);
      }
    }
  });
}

/// A raster that has about as much to tell everywhere; it rises to the right.
HeightGrid rough_grid(std::int32_t side, double rise = 0) {
  oracles::Random random(11);
  std::vector<double> noise;
  for (std::int32_t i = 0; i < side * side; ++i)
    noise.push_back(static_cast<double>(random.below(1000)));
  return delaunay::test::make_grid<float>(side, side, [&](std::int32_t x, std::int32_t y) {
    return noise[static_cast<std::size_t>(y * side + x)] + 300 * std::sin(0.05 * x) +
           200 * std::cos(0.07 * y) + rise * x;
  });
}

class insertions_reads : public insertions_pages {
 protected:
  /// What of a file's bytes a question reads beyond what opening does.
  template <typename Ask>
  double share_of(std::uint64_t size, const Ask& ask) {
    const auto file = HistoryFile::open(path_);
    EXPECT_TRUE(file) << file.error().message;
    const std::uint64_t n_opening = file->reads().n_bytes;
    EXPECT_LT(n_opening, size / 20);
    ask(*file);
    return static_cast<double>(file->reads().n_bytes - n_opening) / static_cast<double>(size);
  }
};

/// Of a slope that rises by 48,000 in all, and errs by a thousand at the base: a height crosses a
/// strip of it.
TEST_F(insertions_reads, are_near_the_lines_of_a_height) {
  const LevelledHistory made{test::history_of(rough_grid(240, 200), 1, Model::delaunay_pyramid),
                             {1000, 500, 250, 1}};
  const auto size = save(made, path_, progress_, {.n_nodes = 128});
  ASSERT_TRUE(size) << size.error().message;
  const std::array<double, 1> height{24000};
  EXPECT_LT(
      share_of(*size,
               [&](const HistoryFile& file) {
                 const auto tin = tin_crossing(file, file.n_nodes(), height, kNone, progress_);
                 ASSERT_TRUE(tin && *tin);
                 EXPECT_GT(count_crossing(**tin, height), 240U);
                 EXPECT_LT(expected_crossing(file, file.n_nodes(), height), 0.6 * file.n_nodes());
               }),
      0.35);
  EXPECT_LT(share_of(*size,
                     [&](const HistoryFile& file) {
                       const auto range = height_range(file, file.n_nodes(), kNone, progress_);
                       ASSERT_TRUE(range && *range);
                     }),
            0.35);
}

TEST_F(insertions_reads, are_of_what_a_question_takes) {
  const HeightGrid grid = rough_grid(240);
  const LevelledHistory made{test::history_of(grid, 1, Model::delaunay_pyramid),
                             {1000, 500, 250, 1}};
  const auto size = save(made, path_, progress_, {.n_nodes = 128});
  ASSERT_TRUE(size) << size.error().message;
  const auto share = [&](const auto& ask) { return share_of(*size, ask); };
  const auto around = [&](const HistoryFile& file, std::uint32_t time) {
    const std::vector<delaunay::Point> places{{{100.5, 70.25}}};
    const auto tin = tin_around(file, time, places, progress_);
    ASSERT_TRUE(tin);
    EXPECT_EQ(tin->triangles.size(), 1U);
  };
  EXPECT_LT(share([&](const HistoryFile& file) { around(file, file.n_nodes()); }), 0.07);
  EXPECT_LT(
      share([&](const HistoryFile& file) {
        const auto tin = tin_along(file, file.n_nodes(), {{10, 20.5}}, {{60, 24.5}}, progress_);
        ASSERT_TRUE(tin);
      }),
      0.1);
  // One percent of the domain.
  const Demand box = FocusDemand{
      .foci = {BoxFocus{{{{100, 100, -1e9}}, {{124, 124, 1e9}}}}}, .inside = 1, .outside = 1e9};
  EXPECT_LT(share([&](const HistoryFile& file) {
              const auto tin = select_tin(file, box, TinLinks::kept, file.n_nodes(), progress_);
              ASSERT_TRUE(tin);
              ASSERT_TRUE(*tin);
              EXPECT_GT((*tin)->triangles.size(), 900U);
            }),
            0.14);
  EXPECT_LT(share([&](const HistoryFile& file) {
              const std::uint32_t time = step_within(file.steps(), 1000).time;
              ASSERT_TRUE(replay(file, file.n_bands_before(time), progress_));
            }),
            0.3);
  EXPECT_GT(share([&](const HistoryFile& file) {
              ASSERT_TRUE(replay(file, file.bands().size(), progress_));
            }),
            0.9);
}

}  // namespace
}  // namespace lode::insertions
