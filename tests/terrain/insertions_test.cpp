#include "lode/models/terrain/insertions/history_locator.h"
#include "lode/models/terrain/insertions/overlap.h"
#include "lode/models/terrain/insertions/persist.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/terrain/insertions_fixtures.h"

namespace lode::insertions {
namespace {

using delaunay::LatticePoint;
using delaunay::Tin;
using delaunay::TinLinks;
using test::box_demand;
using test::by_rounds;
using test::Case;
using test::cases;
using test::expect_true;
using test::grid_with_gaps;
using test::history_of;
using test::is_delaunay;
using test::kModels;

struct ModelCase {
  std::string name;
  HeightGrid grid;
  Model model;
};

std::vector<ModelCase> cases_by_model() {
  std::vector<ModelCase> all;
  for (const Model model : kModels)
    for (Case& c : cases())
      all.push_back({std::string(model_name(model)) + ", " + c.name, std::move(c.grid), model});
  return all;
}

TEST(insertions, remembers_every_mesh_on_the_way) {
  const HeightGrid grid = grid_with_gaps();
  for (const Model model : kModels) {
    const History history = history_of(grid, 60, model);
    ASSERT_GT(history.n_nodes(), 50U);
    for (std::uint32_t time = 0; time <= history.n_nodes(); time += oracles::trials(7U, 31U)) {
      const Tin tin = tin_at(history, time, TinLinks::left_out);
      EXPECT_EQ(tin.vertices.size(), history.n_base_vertices + time);
      delaunay::test::expect_fills(tin, grid);
      if (is_delaunay(model)) delaunay::test::expect_locally_delaunay(tin);
    }
  }
}

TEST(insertions, errors_of_triangles_hold_at_their_samples) {
  const HeightGrid grid = delaunay::test::make_grid<std::int16_t>(33, 21, test::terrain);
  for (const Model model : kModels) {
    const History history = history_of(grid, 5, model);
    for (const Triangle& triangle : history.triangles) {
      Tin one;
      one.triangles = {triangle.corner};
      place_vertices(history, one);
      const auto error = static_cast<double>(delaunay::test::largest_error(one, grid));
      const auto stated = static_cast<double>(triangle.error);
      EXPECT_LE(error, stated);
      EXPECT_LE(stated, error * (1 + 0x1p-7)) << "is rounded up to 8 bits, and by nothing else";
    }
  }
}

TEST(insertions, gives_the_fewest_nodes_of_a_demand) {
  for (const ModelCase& c : cases_by_model()) {
    const History history = history_of(c.grid, 2, c.model);
    for (const Demand& demand :
         {uniform_demand(300), uniform_demand(20), box_demand(4, 500), box_demand(30, 90)}) {
      SCOPED_TRACE(c.name);
      const AppliedNodes applied = select_nodes(history, demand);
      EXPECT_EQ(applied, by_rounds(history, demand));
      delaunay::test::expect_fills(tin_of(history, applied, TinLinks::kept), c.grid);
    }
  }
}

/// Each node with a chance of one in `n`, and all that these depend on.
AppliedNodes random_set(const History& history, oracles::Random& random, std::size_t n) {
  AppliedNodes applied(history.n_nodes());
  for (std::uint32_t node = history.n_nodes(); node-- > 0;) {
    if (!applied[node] && random.below(n) > 0) continue;
    applied[node] = true;
    for (const std::uint32_t t : history.removed_by(node))
      if (history.birth(t) != kNone) applied[history.birth(t)] = true;
  }
  return applied;
}

TEST(insertions, are_delaunay_in_any_mixture) {
  oracles::Random random(11);
  for (const ModelCase& c : cases_by_model()) {
    SCOPED_TRACE(c.name);
    const History history = history_of(c.grid, 2, c.model);
    for (const std::size_t n : {400, 100, 30, 8, 2}) {
      const Tin tin = tin_of(history, random_set(history, random, n), TinLinks::kept);
      delaunay::test::expect_fills(tin, c.grid);
      if (is_delaunay(c.model)) delaunay::test::expect_locally_delaunay(tin);
    }
  }
}

TEST(insertions, keeps_tolerances_that_vary) {
  for (const ModelCase& c : cases_by_model()) {
    SCOPED_TRACE(c.name);
    const History history = history_of(c.grid, 2, c.model);
    const Tin tin = tin_of(history, select_nodes(history, box_demand(5, 250)), TinLinks::kept);
    expect_true(tin, c.grid, 250);
    Tin inside = tin;
    std::erase_if(inside.triangles, [&](const auto& corners) {
      return std::ranges::none_of(corners, [&](std::uint32_t vertex) {
        const LatticePoint p = tin.vertices[vertex];
        return p.x >= 10 && p.x <= 19 && p.y >= 5 && p.y <= 12;
      });
    });
    EXPECT_LE(static_cast<double>(delaunay::test::largest_error(inside, c.grid)), 5);
    const Tin fine = tin_of(history, select_nodes(history, uniform_demand(5)), TinLinks::kept);
    EXPECT_LE(tin.triangles.size(), fine.triangles.size());
  }
}

bool is_in_mesh(const History& history, const NodeSet& nodes, std::uint32_t t) {
  const std::uint32_t birth = history.birth(t);
  return (birth == kNone || nodes.has(birth)) && !nodes.has(history.triangles[t].death);
}

/// Whether a triangle of the nodes' mesh holds a place, looked for among all.
bool is_covered(const History& history, const NodeSet& nodes, LatticePoint p) {
  for (std::uint32_t t = 0; t < history.triangles.size(); ++t) {
    const auto& corner = history.triangles[t].corner;
    if (is_in_mesh(history, nodes, t) &&
        holds(
            {history.vertices[corner[0]], history.vertices[corner[1]], history.vertices[corner[2]]},
            p))
      return true;
  }
  return false;
}

TEST(insertions, find_places_and_windows_as_a_search_does) {
  for (const ModelCase& c : cases_by_model()) {
    SCOPED_TRACE(c.name);
    const History history = history_of(c.grid, 20, c.model);
    const HistoryLocator locator(history);
    const delaunay::Window window{{c.grid.n_columns / 4, c.grid.n_rows / 3},
                                  {c.grid.n_columns / 2, c.grid.n_rows / 3 + 2}};
    for (const double tolerance :
         oracles::trials<std::vector<double>>({500.0, 60.0, 20.0}, {60.0})) {
      const NodeSet nodes = nodes_within(history, tolerance);
      for (std::int32_t y = 0; y < c.grid.n_rows; ++y)
        for (std::int32_t x = 0; x < c.grid.n_columns; ++x) {
          const auto found =
              locator.find(nodes, {{static_cast<double>(x), static_cast<double>(y)}});
          ASSERT_EQ(found.has_value(), is_covered(history, nodes, {x, y}));
          if (!found) continue;
          const auto& corner = history.triangles[*found].corner;
          EXPECT_TRUE(is_in_mesh(history, nodes, *found));
          EXPECT_TRUE(holds({history.vertices[corner[0]], history.vertices[corner[1]],
                             history.vertices[corner[2]]},
                            {x, y}));
        }
      std::vector<std::uint32_t> expected;
      for (std::uint32_t t = 0; t < history.triangles.size(); ++t) {
        const auto& corner = history.triangles[t].corner;
        if (is_in_mesh(history, nodes, t) &&
            delaunay::meets_window({history.vertices[corner[0]], history.vertices[corner[1]],
                                    history.vertices[corner[2]]},
                                   window))
          expected.push_back(t);
      }
      EXPECT_EQ(zoom_in(history, nodes, window), expected);
    }
  }
}

TEST(insertions, have_no_more_triangles_than_asked_for) {
  for (const ModelCase& c : cases_by_model()) {
    SCOPED_TRACE(c.name);
    const History history = history_of(c.grid, 2, c.model);
    std::size_t before = 0;
    for (const std::uint64_t most : {1, 8, 50, 51, 300, 1000000}) {
      const auto nodes = nodes_of_cells(history, most);
      EXPECT_EQ(nodes.has_value(), history.n_base_triangles() <= most);
      if (!nodes) continue;
      const Tin tin = tin_of(history, *nodes, TinLinks::left_out);
      EXPECT_LE(tin.triangles.size(), most);
      EXPECT_GE(tin.triangles.size(), before);
      before = tin.triangles.size();
      delaunay::test::expect_fills(tin, c.grid);
    }
    const Tin all = tin_of(history, nodes_within(history, history.max_error), TinLinks::left_out);
    EXPECT_EQ(before, all.triangles.size());
  }
}

TEST(insertions, are_the_fewest_at_one_tolerance) {
  for (const ModelCase& c : cases_by_model()) {
    SCOPED_TRACE(c.name);
    if (c.model == Model::implicit_delaunay_pyramid) continue;
    const History history = history_of(c.grid, 2, c.model);
    for (const double tolerance : {500.0, 77.0, 10.0, 2.0}) {
      const std::uint32_t time = time_within(history, tolerance);
      const AppliedNodes applied = select_nodes(history, uniform_demand(tolerance));
      for (std::uint32_t node = 0; node < history.n_nodes(); ++node)
        EXPECT_EQ(applied[node], node < time);
    }
  }
}

}  // namespace
}  // namespace lode::insertions
