// Edges collapse to their midpoints: hierarchies and their cuts, held against brute force.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "lode/models/tetra_mt/midpoint/edge_collapser.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/one_shot.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/midpoint_checks.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Cut;
using oracles::noise_mesh;
using oracles::Random;

/// A mesh with a cavity.
TetraMesh holed_mesh(int n, Cut cut) {
  TetraMesh mesh = noise_mesh(n, cut, 21);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return length(centre - Vec3d{{0.5, 0.5, 0.3}}) < 0.2;
  });
  return mesh;
}

std::set<std::uint32_t> used_vertices(const TetraMesh& mesh) {
  std::set<std::uint32_t> used;
  for (const auto& t : mesh.tetrahedra) used.insert(t.begin(), t.end());
  return used;
}

void expect_valid(const Built& b, const MidpointCut& cut) {
  const double volume = test::volume_of(b.reference, b.reference.tetrahedra);
  EXPECT_NEAR(test::expect_conforming(b.vertices, cut.cells()), volume, 1e-6 * volume);
}

/// Positions and values as the cut itself says they are.
void expect_reference(const Built& b, const MidpointCut& cut) {
  EXPECT_EQ(test::normalised(cut.cells()), test::normalised(b.reference.tetrahedra));
  for (const auto& t : cut.cells())
    for (const std::uint32_t v : t) {
      EXPECT_EQ(cut.position(v).v, b.reference.positions[v].v);
      EXPECT_EQ(cut.value(v), b.reference.fields[0].values[v]);
    }
}

/// Dependencies by the definition: a node depends on what made the tetrahedra that it replaces.
std::vector<std::set<std::uint32_t>> brute_parents(const Built& b) {
  using Cell = std::array<std::uint32_t, 4>;
  const Hierarchy& h = b.hierarchy;
  const auto sorted = [](Cell c) {
    std::ranges::sort(c);
    return c;
  };
  test::Tetrahedra closed = b.reference.tetrahedra;
  EXPECT_TRUE(close_boundary(h.n_vertices, closed, {1}));
  std::map<std::uint32_t, std::set<Cell>> stars;
  std::map<Cell, std::uint32_t> makers;
  const auto insert = [&](const Cell& c) {
    for (const std::uint32_t v : c) EXPECT_TRUE(stars[v].insert(c).second);
  };
  for (Cell c : closed) {
    std::ranges::replace(c, h.n_vertices, h.outside());
    insert(sorted(c));
  }
  std::vector<std::set<std::uint32_t>> parents(h.n_nodes());
  for (std::uint32_t node = 0; node < h.n_nodes(); ++node) {
    const auto [first, second] = h.children(node);
    const std::uint32_t made = h.n_vertices + node;
    std::set<Cell> gone = stars[first];
    gone.insert(stars[second].begin(), stars[second].end());
    for (const Cell& c : gone) {
      for (const std::uint32_t v : c) stars[v].erase(c);
      if (const auto maker = makers.find(c); maker != makers.end())
        parents[maker->second].insert(node);
    }
    for (Cell c : gone) {
      if (std::ranges::count(c, first) + std::ranges::count(c, second) != 1) continue;
      std::ranges::replace(c, first, made);
      std::ranges::replace(c, second, made);
      insert(sorted(c));
      makers[sorted(c)] = node;
    }
  }
  return parents;
}

TEST(midpoint, refined_in_any_order_is_the_reference_and_coarsened_the_base) {
  for (const Cut split : {Cut::in_five, Cut::in_six}) {
    const Built b = built(holed_mesh(11, split), 100);
    ASSERT_GT(b.hierarchy.n_nodes(), 800U);
    EXPECT_EQ(b.hierarchy.n_base_cells, b.collapses.n_base_cells);
    MidpointCut cut(b.forest);
    const auto base = test::normalised(cut.cells());
    expect_valid(b, cut);
    Random random(4);
    for (int round = 0; round < 2; ++round) {
      std::vector<std::uint32_t> left(b.hierarchy.n_nodes());
      for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
      std::vector<std::uint32_t> order;
      std::uint64_t n_cells = b.hierarchy.n_base_cells;
      while (!left.empty()) {
        std::swap(left[random.below(left.size())], left.back());
        if (!cut.may_split(NodeId{left.back()})) continue;
        n_cells += cut.apply(NodeId{left.back()});
        order.push_back(left.back());
        left.pop_back();
        if (order.size() % 300 != 0) continue;
        EXPECT_EQ(cut.cells().size(), n_cells);
        expect_valid(b, cut);
      }
      expect_reference(b, cut);
      for (std::size_t i = order.size(); i-- > 0;) n_cells -= cut.undo(NodeId{order[i]});
      EXPECT_EQ(test::normalised(cut.cells()), base);
      EXPECT_EQ(n_cells, b.hierarchy.n_base_cells);
    }
  }
}

TEST(midpoint, labels_allow_what_brute_force_does) {
  for (const Cut split : {Cut::in_five, Cut::in_six}) {
    const Built b = built(holed_mesh(8, split), 60);
    const auto parents = brute_parents(b);
    const std::uint32_t n = b.hierarchy.n_nodes();
    std::vector<std::set<std::uint32_t>> children(n);
    for (std::uint32_t node = 0; node < n; ++node)
      for (const std::uint32_t parent : parents[node]) children[parent].insert(node);
    MidpointCut cut(b.forest);
    std::vector<bool> is_applied(n, false);
    const auto has = [&](std::uint32_t node) { return is_applied[node]; };
    Random random(9);
    for (int step = 0; step < 1200; ++step) {
      std::vector<std::uint32_t> splits;
      std::vector<std::uint32_t> collapses;
      for (std::uint32_t node = 0; node < n; ++node) {
        if (!is_applied[node] && std::ranges::all_of(parents[node], has)) splits.push_back(node);
        if (is_applied[node] && std::ranges::none_of(children[node], has))
          collapses.push_back(node);
        ASSERT_EQ(cut.may_split(NodeId{node}), !splits.empty() && splits.back() == node);
        ASSERT_EQ(cut.may_collapse(NodeId{node}), !collapses.empty() && collapses.back() == node);
      }
      const bool is_up = step % 600 < 400;
      const auto& possible = is_up ? splits : collapses;
      if (possible.empty()) continue;
      const std::uint32_t node = possible[random.below(possible.size())];
      is_applied[node] = is_up;
      if (!is_up) {
        cut.undo(NodeId{node});
        continue;
      }
      // The complete list names all that the node depends on, and ancestors only.
      std::vector<NodeId> named;
      cut.add_parents(NodeId{node}, named);
      for (const NodeId parent : named) EXPECT_TRUE(has(static_cast<std::uint32_t>(parent)));
      for (const std::uint32_t parent : parents[node])
        EXPECT_TRUE(std::ranges::find(named, NodeId{parent}) != named.end());
      cut.apply(NodeId{node});
    }
  }
}

TEST(midpoint, is_the_same_for_any_number_of_threads) {
  TetraMesh mesh =
      test::with_fields(noise_mesh(oracles::trials(24, 19), Cut::in_five, 5));  // several blocks
  mesh.fields.resize(2);
  const EdgeCollapses one = collapsed(mesh, 5'000, 1);
  const EdgeCollapses three = collapsed(mesh, 5'000, 3);
  ASSERT_EQ(one.collapses.size(), three.collapses.size());
  for (std::size_t i = 0; i < one.collapses.size(); ++i) {
    EXPECT_EQ(one.collapses[i].kept, three.collapses[i].kept);
    EXPECT_EQ(one.collapses[i].removed, three.collapses[i].removed);
    for (const std::size_t f : {2 * i, 2 * i + 1}) {
      EXPECT_EQ(one.facts[f].error, three.facts[f].error);
      EXPECT_EQ(one.facts[f].value, three.facts[f].value);
    }
  }
  EXPECT_EQ(one.errors, three.errors);
  EXPECT_LT(one.n_base_cells, 5'050U);
  EXPECT_GT(one.n_base_cells, 4'500U);
}

TEST(midpoint, engine_and_one_shot_find_the_same_and_errors_are_true) {
  const Built b = built(holed_mesh(10, Cut::in_five), 100);
  MidpointCut refined(b.forest);
  Engine<MidpointCut> engine(refined);
  Random random(9);
  for (int trial = 0; trial < 12; ++trial) {
    const double tolerance = trial % 3 == 0 ? 0 : random.uniform(0, 0.3);
    const double isovalue = random.uniform(-0.4, 0.4);
    const bool is_uniform = trial % 4 == 1;
    const Demand demand([=](const NodeFacts& facts) {
      if (!is_uniform && !facts.range.crosses(isovalue)) return 0.0;
      return tolerance == 0 ? 1 + facts.error : facts.error - tolerance;
    });
    engine.set_query(demand);
    engine.finish();
    MidpointCut direct(b.forest);
    const lode::Cut cut = one_shot(direct, demand);
    EXPECT_EQ(cut.applied(), engine.cut().applied());
    EXPECT_EQ(test::normalised(direct.cells()), test::normalised(refined.cells()));
    expect_valid(b, refined);
    if (!is_uniform) continue;
    const std::vector<double>& values = b.reference.fields[0].values;
    for (const std::uint32_t v : used_vertices(b.reference)) {
      const test::Located found =
          test::locate(b.vertices, direct.cells(), b.reference.positions[v], 0);
      EXPECT_LE(std::abs(found.value - values[v]), tolerance + 1e-6);
    }
  }
}

TEST(midpoint, has_the_errors_that_a_search_finds) {
  for (const Cut split : {Cut::in_five, Cut::in_six}) {
    const Built b = built(noise_mesh(10, split, 3), 150);
    const MidpointCut cut(b.forest);
    const std::vector<double>& values = b.reference.fields[0].values;
    const auto [low, high] = std::ranges::minmax(values);
    for (std::size_t v = 0; v < values.size(); ++v) {
      const test::Located found =
          test::locate(b.vertices, cut.cells(), b.reference.positions[v], 0);
      EXPECT_GT(found.least_weight, -1e-4);
      EXPECT_NEAR(
          static_cast<double>(b.collapses.errors[b.hierarchy.mesh_vertices[v]]) * (high - low),
          values[v] - found.value, 1e-4 * (high - low));
    }
  }
}

TEST(midpoint, cells_of_an_isovalue_are_the_references) {
  const Built b = built(holed_mesh(10, Cut::in_six), 100);
  MidpointCut cut(b.forest);
  const double isovalue = 0.6;
  static_cast<void>(one_shot(cut, Demand([=](const NodeFacts& facts) {
                               return facts.range.crosses(isovalue) ? 1.0 : 0.0;
                             })));
  const auto crossed = [&](const TetraMesh& mesh, const test::Tetrahedra& cells) {
    test::Tetrahedra found;
    for (const auto& t : cells) {
      int n_above = 0;
      for (const std::uint32_t v : t) n_above += mesh.fields[0].values[v] >= isovalue ? 1 : 0;
      if (n_above % 4 != 0) found.push_back(t);
    }
    return test::normalised(found);
  };
  EXPECT_EQ(crossed(b.vertices, cut.cells()), crossed(b.reference, b.reference.tetrahedra));
  EXPECT_LT(cut.cells().size(), b.reference.tetrahedra.size());
}

/// Conforming, of the same volume and range, and refined the reference.
Built expect_sound(const TetraMesh& mesh, std::uint64_t base_cells = 0) {
  Built b = built(mesh, base_cells);
  MidpointCut cut(b.forest);
  expect_valid(b, cut);
  std::set<std::uint32_t> left;
  for (const auto& t : cut.cells()) left.insert(t.begin(), t.end());
  const auto range = [](const TetraMesh& of, const std::set<std::uint32_t>& vertices) {
    double low = 0;
    double high = 0;
    for (const std::uint32_t v : vertices) {
      const double value = of.fields[0].values[v];
      low = v == *vertices.begin() ? value : std::min(low, value);
      high = v == *vertices.begin() ? value : std::max(high, value);
    }
    return std::pair(low, high);
  };
  const auto [low, high] = range(b.vertices, left);
  const auto [expected_low, expected_high] = range(mesh, used_vertices(mesh));
  EXPECT_NEAR(low, expected_low, 0x1p-30 * (expected_high - expected_low));
  EXPECT_NEAR(high, expected_high, 0x1p-30 * (expected_high - expected_low));
  Engine<MidpointCut> engine(cut);
  engine.set_query(Demand([](const NodeFacts&) { return 1.0; }));
  engine.finish();
  expect_reference(b, cut);
  return b;
}

/// The cells of a grid that `keeps` says yes to.
template <typename Keeps>
TetraMesh part_of_grid(int n, const Keeps& keeps) {
  TetraMesh mesh = noise_mesh(n, Cut::in_six, 11);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return !keeps(centre * (n - 1));
  });
  return mesh;
}

TEST(midpoint, keeps_cavities_handles_components_and_what_is_no_manifold) {
  expect_sound(part_of_grid(9, [](const Vec3d& p) {
    return p[0] < 3 || p[0] > 5 || p[1] < 3 || p[1] > 5 || p[2] < 3 || p[2] > 5;
  }));
  expect_sound(
      part_of_grid(9, [](const Vec3d& p) { return p[0] < 3 || p[0] > 5 || p[1] < 3 || p[1] > 5; }));
  expect_sound(part_of_grid(10, [](const Vec3d& p) {
    return static_cast<int>(p[0]) % 2 == 0 && (p[1] < 4 || p[1] > 5);
  }));
  expect_sound(part_of_grid(9, [](const Vec3d& p) { return (p[0] < 4) == (p[1] < 4); }));
  expect_sound(part_of_grid(9, [](const Vec3d& p) {
    return (p[0] < 4 && p[1] < 4 && p[2] < 4) || (p[0] > 4 && p[1] > 4 && p[2] > 4);
  }));
}

TEST(midpoint, takes_the_smallest_meshes_and_fields_without_range) {
  TetraMesh mesh = noise_mesh(9, Cut::in_five, 1);
  std::ranges::fill(mesh.fields[0].values, 3.5);
  EXPECT_LT(expect_sound(mesh).hierarchy.n_base_cells, 20U);  // a box
  mesh = noise_mesh(2, Cut::in_six, 1);
  expect_sound(mesh);
  mesh.tetrahedra.resize(2);
  EXPECT_EQ(expect_sound(mesh).hierarchy.n_base_cells, 2U);
  mesh.tetrahedra.resize(1);
  EXPECT_EQ(expect_sound(mesh).hierarchy.n_base_cells, 1U);
  mesh.tetrahedra.clear();
  EXPECT_EQ(built(mesh, 0).hierarchy.n_base_cells, 0U);
  TetraMesh empty;
  empty.fields.emplace_back();
  EXPECT_EQ(built(empty, 0).hierarchy.n_labels(), 0U);
}

TEST(midpoint, takes_a_single_layer_far_longer_than_thick) {
  TetraMesh mesh = part_of_grid(20, [](const Vec3d& p) { return p[2] < 1; });
  for (Vec3d& p : mesh.positions) p[2] *= 1e-4;
  const Built b = expect_sound(mesh);
  EXPECT_LT(b.hierarchy.n_base_cells, mesh.tetrahedra.size() / 2);
}

/// As in tetra_cut_test: at all vertices F' is as near as the cut of a tolerance promises.
void expect_within(const TetraMesh& mesh, double tolerance) {
  const Built b = built(mesh, 60);
  MidpointCut cut(b.forest);
  static_cast<void>(
      one_shot(cut, Demand([=](const NodeFacts& facts) { return facts.error - tolerance; })));
  const auto cells = cut.cells();
  EXPECT_LT(cells.size(), mesh.tetrahedra.size());
  const std::vector<double>& values = mesh.fields[0].values;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const test::Located found = test::locate(b.vertices, cells, mesh.positions[v], 0);
    EXPECT_LE(std::abs(found.value - values[v]), tolerance * (1 + 1e-9));
  }
}

TEST(midpoint, is_true_in_domains_and_ranges_of_all_sizes) {
  const TetraMesh mesh = noise_mesh(8, Cut::in_six, 2);
  for (const double scale : {1e-12, 1e17, 1e-100, 1e100}) {
    TetraMesh scaled = mesh;
    for (Vec3d& p : scaled.positions) {
      p[0] = p[0] * p[0];  // graded
      p = p * scale;
    }
    expect_within(scaled, 0.15);
  }
  for (const double thickness : {1e-2, 1e-4}) {
    TetraMesh slab = mesh;
    for (Vec3d& p : slab.positions) {
      const double z = thickness * p[2];
      p = {{0.8 * p[0] - 0.6 * z, p[1], 0.6 * p[0] + 0.8 * z}};
    }
    expect_within(slab, 0.15);
  }
  for (const double scale : {1e30, 1e-30}) {
    TetraMesh scaled = mesh;
    for (double& value : scaled.fields[0].values) value *= scale;
    expect_within(scaled, 0.15 * scale);
  }
  TetraMesh moved = mesh;
  for (double& value : moved.fields[0].values) value += 1e9;
  expect_within(moved, 0.15);
}

TEST(midpoint, keeps_regions_and_what_lies_between_them) {
  TetraMesh mesh = noise_mesh(10, Cut::in_six, 6);
  mesh.region_ids = {3, 5, 9};
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(centre[0] < 0.5 ? 0 : centre[1] < 0.34 ? 1 : 2);
  }
  const Built b = expect_sound(mesh);
  EXPECT_LT(b.hierarchy.n_base_cells, mesh.tetrahedra.size() / 4);
  MidpointCut cut(b.forest);
  const auto volumes = [&] {
    std::array<double, 3> sums{};
    for (const MidpointCut::Cell& cell : cut.slots())
      if (cut.is_inside(cell)) sums[cell.region] += test::volume_of(b.vertices, {cell.corners});
    return sums;
  };
  std::array<double, 3> expected{};
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    expected[mesh.regions[i]] += test::volume_of(mesh, {mesh.tetrahedra[i]});
  Random random(2);
  for (int round = 0; round < 4; ++round) {
    const auto sums = volumes();
    for (std::size_t r = 0; r < 3; ++r) EXPECT_NEAR(sums[r], expected[r], 1e-8);
    expect_valid(b, cut);
    for (int k = 0; k < 60; ++k) {
      const auto node = static_cast<std::uint32_t>(random.below(b.hierarchy.n_nodes()));
      if (cut.may_split(NodeId{node})) cut.apply(NodeId{node});
    }
  }
  Engine<MidpointCut> engine(cut);
  MidpointCut full(b.forest);
  Engine<MidpointCut> all(full);
  all.set_query(Demand([](const NodeFacts&) { return 1.0; }));
  all.finish();
  std::map<std::array<std::uint32_t, 4>, std::uint32_t> regions;
  const auto sorted = [](std::array<std::uint32_t, 4> t) {
    std::ranges::sort(t);
    return t;
  };
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    regions[sorted(b.reference.tetrahedra[i])] = mesh.regions[i];
  for (const MidpointCut::Cell& cell : full.slots())
    if (full.is_inside(cell)) EXPECT_EQ(regions.at(sorted(cell.corners)), cell.region);
}

TEST(midpoint, nodes_take_no_more_than_the_papers_forty_bytes_a_vertex) {
  TetraMesh mesh = noise_mesh(16, Cut::in_six, 6);
  const Built b = built(mesh, 400);
  EXPECT_LE(b.forest.n_node_bytes(), 40 * mesh.positions.size());
  EXPECT_EQ(b.forest.n_node_bytes(),
            4 * mesh.positions.size() + 36 * std::uint64_t{b.hierarchy.n_nodes()});
  // Of positions and values that the steps hold, nothing else is kept.
  for (Vec3d& p : mesh.positions)
    for (double& x : p.v) x = std::round(x * 15);
  for (double& value : mesh.fields[0].values) value = std::round(value * 1000) + 0.0;  // no -0
  EXPECT_EQ(built(mesh, 400).hierarchy.exact.size(), 0U);
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
