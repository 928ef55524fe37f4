#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <span>

#include "lode/models/terrain/delaunay_selector/spatial_order.h"
#include "lode/models/terrain/insertions/file_layout.h"
#include "lode/models/terrain/insertions/history_file.h"
#include "lode/models/terrain/insertions/local_selection.h"
#include "lode/models/terrain/insertions/overlap.h"
#include "lode/models/terrain/insertions/persist.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/terrain/insertions_fixtures.h"
#include "tests/terrain/model_files.h"

namespace lode::insertions {
namespace {

using lode::test::put;
using lode::test::rewrite;
using lode::test::ScratchFile;
using test::hills;

using test::kModels;

template <typename T>
LevelledHistory make_model(Model model) {
  HeightGrid grid = delaunay::test::make_grid<T>(31, 24, hills);
  for (std::int32_t x = 12; x < 17; ++x) delaunay::test::set_missing(grid, x, 9);
  grid.to_world = {500000.25, 30, 0, 4e6, 0, -30};
  grid.crs = "PROJCS[\"somewhere\"]";
  grid.vertical_unit = "metre";
  History history = test::history_of(grid, 1.5, model);
  history.sample_type = "int16";
  history.has_place = sizeof(T) > 2;
  std::vector<double> levels;
  if (history.is_worst_first()) levels = {20, 6, 1.5};
  return {std::move(history), levels};
}

using test::make_point_model;

void expect_same(const LevelledHistory& a, const LevelledHistory& b) {
  const History& x = a.history;
  const History& y = b.history;
  EXPECT_EQ(a.levels, b.levels);
  EXPECT_EQ(x.model, y.model);
  EXPECT_EQ(x.level_ends, y.level_ends);
  EXPECT_EQ(x.is_of_points, y.is_of_points);
  EXPECT_EQ(x.lines, y.lines);
  EXPECT_EQ(x.frame.to_world, y.frame.to_world);
  EXPECT_EQ(x.frame.n_columns, y.frame.n_columns);
  EXPECT_EQ(x.frame.n_rows, y.frame.n_rows);
  EXPECT_EQ(x.frame.crs, y.frame.crs);
  EXPECT_EQ(x.frame.vertical_unit, y.frame.vertical_unit);
  EXPECT_EQ(x.sample_type, y.sample_type);
  EXPECT_EQ(x.has_place, y.has_place);
  EXPECT_EQ(x.range.lower, y.range.lower);
  EXPECT_EQ(x.range.upper, y.range.upper);
  EXPECT_EQ(x.n_samples, y.n_samples);
  EXPECT_EQ(x.n_missing, y.n_missing);
  EXPECT_EQ(x.n_left_out, y.n_left_out);
  EXPECT_EQ(x.max_error, y.max_error);
  EXPECT_EQ(x.vertices, y.vertices);
  EXPECT_EQ(x.heights, y.heights);
  EXPECT_EQ(x.first_made, y.first_made);
  EXPECT_EQ(x.removed, y.removed);
  EXPECT_EQ(x.first_removed, y.first_removed);
  ASSERT_EQ(x.triangles.size(), y.triangles.size());
  for (std::size_t t = 0; t < x.triangles.size(); ++t) {
    EXPECT_EQ(x.triangles[t].corner, y.triangles[t].corner);
    EXPECT_EQ(x.triangles[t].death, y.triangles[t].death);
    EXPECT_EQ(x.triangles[t].error, y.triangles[t].error);
  }
}

template <typename T>
class insertions_file : public testing::Test {};
using Types = testing::Types<std::int16_t, std::uint16_t, float, double>;
TYPED_TEST_SUITE(insertions_file, Types);

TYPED_TEST(insertions_file, has_all_that_was_saved) {
  const ScratchFile file("whole.lode");
  const std::string& path = file.path();
  for (const Model model : kModels) {
    const LevelledHistory made = make_model<TypeParam>(model);
    Progress progress;
    const auto size = save(made, path, progress);
    ASSERT_TRUE(size) << size.error().message;
    EXPECT_EQ(*size, std::filesystem::file_size(path));
    EXPECT_TRUE(HistoryFile::open(path));
    const auto opened = open(path, progress);
    ASSERT_TRUE(opened) << opened.error().message;
    expect_same(made, *opened);
  }
}

constexpr std::array kPointModels{Model::delaunay_pyramid, Model::ternary_triangulation};

TEST(insertions_point_file, has_all_that_was_saved) {
  const ScratchFile file("points.lode");
  for (const Model model : kPointModels) {
    const LevelledHistory made = make_point_model(model);
    EXPECT_EQ(made.history.lines.size(), 1U);
    Progress progress;
    ASSERT_TRUE(save(made, file.path(), progress));
    const auto opened = open(file.path(), progress);
    ASSERT_TRUE(opened) << opened.error().message;
    expect_same(made, *opened);
  }
}

void expect_refused(const std::string& path, const std::string& why) {
  Progress progress;
  const auto opened = open(path, progress);
  ASSERT_FALSE(opened);
  const std::string& message = opened.error().message;
  EXPECT_NE(message.find(path), std::string::npos) << message;
  EXPECT_NE(message.find(why), std::string::npos) << message;
}

TEST(insertions_lies, are_named) {
  const ScratchFile whole("true.lode");
  const ScratchFile lie("lie.lode");
  Progress progress;
  const LevelledHistory made = make_model<float>(Model::delaunay_pyramid);
  ASSERT_TRUE(save(made, whole.path(), progress));
  const auto number = [](Column column) { return static_cast<std::uint32_t>(column); };
  const auto expect = [&](std::uint32_t column, std::size_t at, auto value, const char* why) {
    SCOPED_TRACE(why);
    rewrite(whole.path(), lie.path(),
            [&](std::uint32_t of, std::uint32_t part, std::vector<std::byte>& bytes) {
              if (of == column && part == 0) put(bytes, at, value);
            });
    expect_refused(lie.path(), why);
  };
  expect(0, 0, std::uint32_t{77}, "layout");
  expect(0, 4, std::uint8_t{2}, "kind 2");
  expect(0, 5, std::int32_t{-3}, "columns and rows");
  expect(0, 5, std::int32_t{1 << 30}, "columns and rows");
  expect(0, 13, std::nan(""), "finite numbers");
  expect(0, 21, 0.0, "span a plane");
  expect(number(Column::x), 4, std::int32_t{31}, "column 31");
  expect(number(Column::x), 4, std::int32_t{-1}, "column -1");
  expect(number(Column::height), 4, 1e9F, "heights");
  expect(number(Column::height), 4, std::nanf(""), "heights");
  expect(number(Column::corners), 0, std::uint32_t{1000000}, "vertices of the base");
  expect(number(Column::corners), 0, std::uint32_t{1}, "as its triangles come to them");
  expect(number(Column::corners), 8, std::uint32_t{1}, "turn left");
  for (const Column column : {Column::error, Column::made}) {
    expect(number(column), 0, std::uint16_t{0x7F80}, "errors");
    expect(number(column), 0, std::uint16_t{0x8001}, "errors");
  }
  expect(number(Column::boxes), 0, std::int32_t{-1}, "expected page 0 in");
  expect(number(Column::counts), 0, std::uint32_t{1}, "nodes");
  expect(number(Column::steps), 0, std::uint32_t{0x7F80}, "steps");
}

TEST(insertions_lies, of_points_are_named) {
  const ScratchFile file("points_lie.lode");
  Progress progress;
  const LevelledHistory made = make_point_model(Model::delaunay_pyramid);
  const auto expect = [&](const char* why, const auto& change) {
    SCOPED_TRACE(why);
    LevelledHistory lie = made;
    change(lie.history);
    ASSERT_TRUE(save(lie, file.path(), progress));
    expect_refused(file.path(), why);
  };
  const std::uint32_t base = made.history.n_base_vertices;
  expect("fixed edges", [&](History& h) { h.lines[0] = {h.lines[0][1], h.lines[0][0]}; });
  expect("fixed edges", [&](History& h) { h.lines.push_back({base, base + 1}); });
  expect("fixed edges", [&](History& h) { h.lines.push_back(h.lines.back()); });
  // Of the outline, which has no two sides.
  expect("fixed edges", [&](History& h) {
    h.lines.clear();
    std::set<std::array<std::uint32_t, 2>> edges;
    for (std::uint32_t t = 0; t < h.n_base_triangles(); ++t)
      for (std::size_t i = 0; i < 3; ++i)
        edges.insert({h.triangles[t].corner[i], h.triangles[t].corner[(i + 1) % 3]});
    for (const auto& [a, b] : edges)
      if (a < b && !edges.contains({b, a})) h.lines.assign(1, {a, b});
    ASSERT_FALSE(h.lines.empty());
  });
  // The line is all that keeps its edges.
  expect("expected it to make", [&](History& h) { h.lines.clear(); });
  expect("fixed edges of a base", [&](History& h) { h.lines.resize(100'000); });
  expect("columns and rows", [&](History& h) { h.frame.n_columns = (1 << 30) + 1; });
  expect("expected page", [&](History& h) { h.vertices.back().x = 1 << 29; });
  // Twice the same place, and a corner pulled over the other side.
  expect("covers its domain once", [&](History& h) {
    const auto t = h.triangles[0].corner;
    h.triangles.push_back(h.triangles.back());
    std::copy_backward(h.triangles.begin() + 1, h.triangles.end() - 1, h.triangles.end());
    h.triangles[1] = {t, kNone, 0};
    for (std::uint32_t& first : h.first_made) ++first;
  });
  expect("levels that end", [&](History& h) {
    h.model = Model::implicit_delaunay_pyramid;
    h.level_ends = {h.n_nodes() - 1};
  });
}

TEST(insertions_lies, of_heights_that_no_model_takes_are_named) {
  const ScratchFile file("heights.lode");
  Progress progress;
  for (const Model model : kModels) {
    LevelledHistory made = make_model<double>(model);
    made.history.range.upper = 1e300;
    made.history.heights.back() = 1e300;
    ASSERT_TRUE(save(made, file.path(), progress));
    expect_refused(file.path(), "1e+30");
  }
}

/// Triangles of a base, with vertices in the order in which they come to them.
LevelledHistory history_of_base(Model model, const HeightGrid& grid,
                                std::span<const LatticeCorners> base) {
  LevelledHistory made{test::history_of(grid, 1000, model), {}};
  History& history = made.history;
  history.level_ends.clear();
  history.vertices.clear();
  history.triangles.clear();
  for (const LatticeCorners& places : base) {
    Triangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = std::ranges::find(history.vertices, places[i]) - history.vertices.begin();
      triangle.corner[i] = static_cast<std::uint32_t>(at);
      if (triangle.corner[i] == history.vertices.size()) history.vertices.push_back(places[i]);
    }
    history.triangles.push_back(triangle);
  }
  history.n_base_vertices = static_cast<std::uint32_t>(history.vertices.size());
  history.heights.assign(history.vertices.size(), 0.0);
  history.first_made = {static_cast<std::uint32_t>(base.size())};
  history.removed.clear();
  history.first_removed = {0};
  return made;
}

TEST(insertions_lies, of_the_base_are_named) {
  using Base = std::vector<LatticeCorners>;
  const ScratchFile file("base.lode");
  const HeightGrid grid = delaunay::test::make_grid<float>(5, 5, [](int, int) { return 0; });
  const auto expect = [&](const Base& base, bool is_one) {
    for (const Model model : kModels) {
      Progress progress;
      ASSERT_TRUE(save(history_of_base(model, grid, base), file.path(), progress));
      if (!is_one) {
        expect_refused(file.path(), "covers cells once");
        continue;
      }
      const auto opened = open(file.path(), progress);
      EXPECT_TRUE(opened) << opened.error().message;
    }
  };
  const LatticeCorners lower{{{0, 0}, {2, 0}, {2, 2}}};
  const LatticeCorners upper{{{0, 0}, {2, 2}, {0, 2}}};
  const LatticeCorners right{{{2, 0}, {4, 0}, {4, 2}}};
  const LatticeCorners above_right{{{2, 0}, {4, 2}, {2, 2}}};
  expect({lower, upper}, true);
  expect({lower, upper, right, above_right}, true);
  // Squares that touch at a corner.
  expect({lower, upper, {{{2, 2}, {4, 2}, {4, 4}}}, {{{2, 2}, {4, 4}, {2, 4}}}}, true);
  // An oblique outline; twice the same; the same from corners of its own; a vertex that hangs.
  expect({lower}, false);
  expect({lower, upper, lower}, false);
  expect({lower, upper, lower, upper}, false);
  expect({lower, upper, {{{1, 1}, {3, 1}, {3, 3}}}, {{{1, 1}, {3, 3}, {1, 3}}}}, false);
  expect({lower, upper, {{{2, 0}, {4, 0}, {4, 1}}}, {{{2, 0}, {4, 1}, {2, 1}}}}, false);
}

std::int64_t doubled_area_of(const delaunay::Tin& tin) {
  std::int64_t sum = 0;
  for (const auto& [a, b, c] : tin.triangles) {
    const std::int64_t area =
        delaunay::doubled_area(tin.vertices[a], tin.vertices[b], tin.vertices[c]);
    EXPECT_GT(area, 0);
    sum += area;
  }
  return sum;
}

/// Asks of parts of a file that may lie. Whether all had an answer; those that there are cover what
/// the base does.
bool has_answers(const std::string& path) {
  Progress progress;
  const auto file = HistoryFile::open(path);
  if (!file) return false;
  bool has_all = true;
  const History& base = file->base();
  const std::int64_t area = doubled_area_of(tin_at(base, 0, delaunay::TinLinks::left_out));
  for (const Demand& demand : {uniform_demand(0), test::box_demand(0, 20)}) {
    const auto tin = select_tin(*file, demand, delaunay::TinLinks::kept, file->n_nodes(), progress);
    has_all = has_all && tin.has_value();
    if (tin) EXPECT_EQ(doubled_area_of(**tin), area);
    if (!tin) EXPECT_NE(tin.error().message.find(path), std::string::npos) << tin.error().message;
  }
  const double width = base.frame.n_columns - 1;
  const double height = base.frame.n_rows - 1;
  const std::vector<delaunay::Point> places{
      {{0.4 * width, 0.3 * height}}, {{width, 0}}, {{0.5 * width, 0.5 * height}}};
  const auto around = tin_around(*file, file->n_nodes(), places, progress);
  const auto along =
      tin_along(*file, file->n_nodes(), {{-1, 0.2 * height}}, {{width, height}}, progress);
  if (around) doubled_area_of(*around);
  if (along) doubled_area_of(*along);
  return has_all && around && along;
}

TEST(insertions_lies, never_make_meshes_that_are_none) {
  const ScratchFile whole("honest.lode");
  const ScratchFile lie("random.lode");
  Progress progress;
  oracles::Random random(5);
  int n_refused = 0;
  int n_refused_in_part = 0;
  const int n_trials = oracles::trials(100, 50);  // of each model
  for (int trial = 0; trial < 5 * n_trials; ++trial) {
    const auto kind = static_cast<std::size_t>(trial / n_trials);
    if (trial % n_trials == 0) {
      ASSERT_TRUE(save(kind < kModels.size()
                           ? make_model<std::int16_t>(kModels[kind])
                           : make_point_model(kPointModels[kind - kModels.size()]),
                       whole.path(), progress, {.n_nodes = 24}));
      EXPECT_TRUE(has_answers(whole.path()));
    }
    const std::size_t victim = random.below(12);
    const std::uint32_t page = static_cast<std::uint32_t>(random.below(4));
    rewrite(whole.path(), lie.path(),
            [&](std::uint32_t column, std::uint32_t part, std::vector<std::byte>& bytes) {
              const bool is_of_page = column >= static_cast<std::uint32_t>(Column::nodes);
              if (column != victim || bytes.empty() || (is_of_page && part != page)) return;
              for (std::size_t k = 0; k <= random.below(3); ++k)
                bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 + random.below(255));
              if (trial % 7 == 0) bytes.resize(1 + random.below(bytes.size()));
            });
    if (!has_answers(lie.path())) ++n_refused_in_part;
    const auto opened = open(lie.path(), progress);
    if (!opened) {
      ++n_refused;
      continue;
    }
    const History& history = opened->history;
    for (const Triangle& triangle : history.triangles)
      EXPECT_GT(delaunay::doubled_area(history.vertices[triangle.corner[0]],
                                       history.vertices[triangle.corner[1]],
                                       history.vertices[triangle.corner[2]]),
                0);
  }
  EXPECT_GT(n_refused, 50);
  EXPECT_GT(n_refused_in_part, 50);
}

/// Pages that are coded as they should be, of nodes that are not.
TEST(insertions_lies, of_nodes_are_refused_by_who_comes_upon_them) {
  const ScratchFile file("nodes.lode");
  Progress progress;
  oracles::Random random(17);
  const int n_trials = oracles::trials(60, 15);  // of each model
  for (int trial = 0; trial < 4 * n_trials; ++trial) {
    const auto kind = static_cast<std::size_t>(trial / n_trials);
    LevelledHistory lie = kind < kModels.size() ? make_model<float>(kModels[kind])
                                                : make_point_model(Model::delaunay_pyramid);
    lie.levels.clear();
    History& history = lie.history;
    const auto any = [&] {
      return history.n_base_vertices + static_cast<std::uint32_t>(random.below(history.n_nodes()));
    };
    const std::uint32_t victim = any();
    std::uint32_t other = any();
    while (other == victim) other = any();
    switch (trial % 5) {
      case 0: std::swap(history.vertices[victim], history.vertices[other]); break;
      // A place that is there already, a corner, and one in the gap.
      case 1: history.vertices[victim] = history.vertices[other]; break;
      case 2: history.vertices[victim] = history.vertices[0]; break;
      case 3: history.vertices[victim] = {14, 9}; break;
      default: history.vertices[victim] = {history.frame.n_columns - 1, 0}; break;
    }
    ASSERT_TRUE(save(lie, file.path(), progress, {.n_nodes = 24}));
    has_answers(file.path());
    if (trial % 5 == 0) continue;  // Two nodes may be as good the other way round.
    EXPECT_FALSE(open(file.path(), progress)) << trial;
  }
}

TEST(insertions_lies, of_pages_are_named_when_they_are_read) {
  const ScratchFile whole("pages.lode");
  const ScratchFile lie("page_lie.lode");
  Progress progress;
  ASSERT_TRUE(
      save(make_model<float>(Model::delaunay_pyramid), whole.path(), progress, {.n_nodes = 24}));
  const auto n_pages = HistoryFile::open(whole.path())->pages().size();
  ASSERT_GT(n_pages, 4U);
  for (const Column column : {Column::nodes, Column::made})
    for (std::uint32_t page = 0; page < n_pages; ++page) {
      rewrite(whole.path(), lie.path(),
              [&](std::uint32_t of, std::uint32_t part, std::vector<std::byte>& bytes) {
                if (of != static_cast<std::uint32_t>(column) || part != page) return;
                std::ranges::fill(bytes, std::byte{0xFF});
              });
      // Opening looks at none.
      const auto opened = HistoryFile::open(lie.path());
      ASSERT_TRUE(opened) << opened.error().message;
      for (std::uint32_t other = 0; other < n_pages; ++other) {
        EXPECT_EQ(opened->read_nodes(other).has_value(), column == Column::made || other != page);
        EXPECT_EQ(opened->read_errors(other).has_value(), column == Column::nodes || other != page);
      }
      expect_refused(lie.path(), "page " + std::to_string(page));
    }
}

}  // namespace
}  // namespace lode::insertions
