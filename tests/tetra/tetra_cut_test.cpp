// Cuts of a hierarchy of half edges, against the collapses done by their definition.

#include "lode/models/tetra_mt/tetra_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "lode/refine/engine.h"
#include "lode/refine/one_shot.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/mesh_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Cut;
using oracles::Random;

struct Built {
  TetraMesh mesh;  ///< Vertices numbered as the hierarchy's.
  Hierarchy hierarchy;
  PackedHierarchy packed;
};

Built built(const TetraMesh& reference, std::uint64_t base_cells) {
  Progress progress;
  const auto collapses = collapse_half_edges(
      reference, {.base_cells = base_cells, .rules = {}, .threads = {2}}, progress);
  EXPECT_TRUE(collapses);
  auto hierarchy = make_hierarchy(reference, *collapses, {2});
  EXPECT_TRUE(hierarchy) << (hierarchy ? "" : hierarchy.error().message);
  auto packed = PackedHierarchy::pack(*hierarchy, reference.tetrahedra.size(), {2});
  Built result{reference, std::move(*hierarchy), std::move(packed)};
  result.mesh.positions = result.hierarchy.positions;
  result.mesh.fields = result.hierarchy.fields;
  // Positions tell which vertex is which.
  std::map<std::array<double, 3>, std::uint32_t> numbers;
  for (std::uint32_t v = 0; v < result.mesh.positions.size(); ++v)
    numbers[result.mesh.positions[v].v] = v;
  for (auto& t : result.mesh.tetrahedra)
    for (std::uint32_t& v : t) v = numbers.at(reference.positions[v].v);
  return result;
}

/// A mesh with a cavity, in several blocks' worth of nodes.
TetraMesh holed_mesh(int n, Cut cut) {
  TetraMesh mesh = oracles::noise_mesh(n, cut, 21);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return length(centre - Vec3d{{0.5, 0.5, 0.3}}) < 0.2;
  });
  return mesh;
}

/// By collapse: what it destroys and what it makes, found without any of the hierarchy's means.
struct Brute {
  std::vector<std::set<std::uint32_t>> parents;
  test::Tetrahedra base;
};

Brute brute_force(const Built& b) {
  using Cell = std::array<std::uint32_t, 4>;
  const std::uint32_t n = b.hierarchy.n_nodes();
  std::set<Cell> live;
  std::map<Cell, std::uint32_t> makers;
  std::map<std::uint32_t, std::set<Cell>> stars;
  const auto sorted = [](Cell c) {
    std::ranges::sort(c);
    return c;
  };
  const auto insert = [&](const Cell& c) {
    live.insert(c);
    for (const std::uint32_t v : c) stars[v].insert(c);
  };
  const auto erase = [&](const Cell& c) {
    live.erase(c);
    for (const std::uint32_t v : c) stars[v].erase(c);
  };
  // The boundary counts: a face that changes there is one to the vertex outside.
  test::Tetrahedra closed = b.mesh.tetrahedra;
  EXPECT_TRUE(close_boundary(b.hierarchy.outside(), closed, {1}));
  for (const Cell& c : closed) insert(sorted(c));
  Brute result;
  result.parents.resize(n);
  for (std::uint32_t i = n; i-- > 0;) {
    const std::uint32_t node = b.hierarchy.order[i];
    const std::uint32_t vertex = b.hierarchy.n_base_vertices + node;
    const std::uint32_t target = b.hierarchy.targets[node];
    const std::set<Cell> star = stars[vertex];
    for (const Cell& c : star) {
      erase(c);
      if (const auto maker = makers.find(c); maker != makers.end()) {
        result.parents[maker->second].insert(node);
        makers.erase(maker);
      }
    }
    for (Cell c : star) {
      if (std::ranges::find(c, target) != c.end()) continue;
      std::ranges::replace(c, vertex, target);
      c = sorted(c);
      EXPECT_FALSE(live.contains(c));
      insert(c);
      makers[c] = node;
    }
  }
  for (const Cell& c : live)
    if (c[3] != b.hierarchy.outside()) result.base.push_back(c);
  return result;
}

test::Tetrahedra sorted_corners(test::Tetrahedra cells) {
  for (auto& c : cells) std::ranges::sort(c);
  std::ranges::sort(cells);
  return cells;
}

void expect_valid(const Built& b, const TetraCut& cut) {
  const double volume = test::volume_of(b.mesh, b.mesh.tetrahedra);
  const auto cells = cut.cells();
  EXPECT_NEAR(test::expect_conforming(b.mesh, cells), volume, 1e-5 * volume);
}

TEST(tetra_cut, depends_on_what_brute_force_finds) {
  for (const Cut split : {Cut::in_five, Cut::in_six}) {
    const Built b = built(holed_mesh(10, split), 200);
    ASSERT_GT(b.hierarchy.n_nodes(), 500U);
    const Brute brute = brute_force(b);
    for (std::uint32_t node = 0; node < b.hierarchy.n_nodes(); ++node) {
      const auto parents = b.hierarchy.parents_of(node);
      EXPECT_EQ(std::set<std::uint32_t>(parents.begin(), parents.end()), brute.parents[node]);
      EXPECT_EQ(std::set<std::uint32_t>(parents.begin(), parents.end()).size(), parents.size());
    }
    EXPECT_EQ(sorted_corners(TetraCut(b.packed).cells()), sorted_corners(brute.base));
  }
}

TEST(tetra_cut, refined_in_any_order_is_the_reference_and_coarsened_the_base) {
  const Built b = built(holed_mesh(12, Cut::in_five), 100);
  TetraCut cut(b.packed);
  const auto base = test::normalised(cut.cells());
  Random random(4);
  for (int round = 0; round < 2; ++round) {
    // Any node whose parents are applied, as long as there is one.
    std::vector<std::uint32_t> n_missing;
    std::vector<std::uint32_t> ready;
    for (std::uint32_t node = 0; node < b.hierarchy.n_nodes(); ++node) {
      n_missing.push_back(static_cast<std::uint32_t>(b.hierarchy.parents_of(node).size()));
      if (n_missing.back() == 0) ready.push_back(node);
    }
    std::vector<std::uint32_t> order;
    std::uint64_t n_cells = b.hierarchy.n_base_cells;
    while (!ready.empty()) {
      std::swap(ready[random.below(ready.size())], ready.back());
      const std::uint32_t node = ready.back();
      ready.pop_back();
      n_cells += cut.apply(NodeId{node});
      order.push_back(node);
      if (order.size() % 300 == 0) {
        EXPECT_EQ(cut.cells().size(), n_cells);
        expect_valid(b, cut);
      }
      for (const std::uint32_t child : b.hierarchy.children_of(node))
        if (--n_missing[child] == 0) ready.push_back(child);
    }
    EXPECT_EQ(order.size(), b.hierarchy.n_nodes());
    EXPECT_EQ(test::normalised(cut.cells()), test::normalised(b.mesh.tetrahedra));
    for (std::size_t i = order.size(); i-- > 0;) n_cells -= cut.undo(NodeId{order[i]});
    EXPECT_EQ(test::normalised(cut.cells()), base);
    EXPECT_EQ(n_cells, b.hierarchy.n_base_cells);
  }
}

TEST(tetra_cut, engine_and_one_shot_find_the_same_and_errors_are_true) {
  const Built b = built(holed_mesh(11, Cut::in_five), 100);
  TetraCut refined(b.packed);
  Engine<TetraCut> engine(refined);
  Random random(9);
  for (int trial = 0; trial < 12; ++trial) {
    const double tolerance = trial % 3 == 0 ? 0 : random.uniform(0, 0.2);
    const double isovalue = random.uniform(-0.4, 0.4);
    const bool is_uniform = trial % 4 == 1;
    const Demand demand([=](const NodeFacts& facts) {
      if (!is_uniform && !facts.range.crosses(isovalue)) return 0.0;
      return tolerance == 0 ? 1 + facts.error : facts.error - tolerance;
    });
    engine.set_query(demand);
    engine.finish();
    TetraCut direct(b.packed);
    const lode::Cut cut = one_shot(direct, demand);
    EXPECT_EQ(cut.applied(), engine.cut().applied());
    EXPECT_EQ(test::normalised(direct.cells()), test::normalised(refined.cells()));
    expect_valid(b, refined);
    if (!is_uniform) continue;
    const std::vector<double>& values = b.mesh.fields[0].values;
    for (std::size_t v = 0; v < values.size(); v += 3) {
      const test::Located found = test::locate(b.mesh, direct.cells(), b.mesh.positions[v], 0);
      EXPECT_LE(std::abs(found.value - values[v]), tolerance + 1e-6);
    }
  }
}

/// At all vertices of the reference F' is as near as the cut of a tolerance promises. `share`: of
/// the cells, what it may have at most.
void expect_within(const TetraMesh& mesh, double tolerance, double share = 0.9) {
  const Built b = built(mesh, 60);
  TetraCut cut(b.packed);
  static_cast<void>(
      one_shot(cut, Demand([=](const NodeFacts& facts) { return facts.error - tolerance; })));
  const auto cells = cut.cells();
  EXPECT_LE(static_cast<double>(cells.size()), share * static_cast<double>(mesh.tetrahedra.size()));
  const std::vector<double>& values = b.mesh.fields[0].values;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const test::Located found = test::locate(b.mesh, cells, b.mesh.positions[v], 0);
    EXPECT_LE(std::abs(found.value - values[v]), tolerance * (1 + 1e-9));
  }
}

TEST(tetra_cut, is_true_beside_outliers_and_of_ranges_and_offsets_of_all_sizes) {
  TetraMesh mesh = oracles::noise_mesh(9, Cut::in_five, 2);
  const std::vector<double> values = mesh.fields[0].values;
  for (const double outlier : {-1e30, -1e7, 1e9}) {
    mesh.fields[0].values = values;
    mesh.fields[0].values[300] = outlier;
    expect_within(mesh, 0.1, 1);  // beside 1e30 floats know no order
  }
  for (const double scale : {1e30, 1e-30, 1e-300}) {
    for (std::size_t v = 0; v < values.size(); ++v) mesh.fields[0].values[v] = scale * values[v];
    if (scale > 1e-40) expect_within(mesh, 0.1 * scale);
  }
  for (std::size_t v = 0; v < values.size(); ++v) mesh.fields[0].values[v] = 1e9 + values[v];
  expect_within(mesh, 0.1);
}

TEST(tetra_cut, is_true_in_domains_of_all_sizes_and_of_thin_cells) {
  const TetraMesh mesh = oracles::noise_mesh(9, Cut::in_six, 2);
  for (const double scale : {1e-12, 1e17, 1e25, 1e-100, 1e100}) {
    TetraMesh scaled = mesh;
    for (Vec3d& p : scaled.positions) {
      p[0] = p[0] * p[0];  // graded
      p = p * scale;
    }
    expect_within(scaled, 0.08);
  }
  for (const double thickness : {1e-2, 1e-4}) {
    TetraMesh slab = mesh;
    for (Vec3d& p : slab.positions) {
      const double z = thickness * p[2];
      p = {{0.8 * p[0] - 0.6 * z, p[1], 0.6 * p[0] + 0.8 * z}};
    }
    expect_within(slab, 0.08);
  }
}

TEST(tetra_cut, ranges_tell_as_much_beside_an_offset) {
  TetraMesh mesh = oracles::noise_mesh(11, Cut::in_five, 2);
  const auto n_cells = [&](double offset) {
    TetraMesh moved = mesh;
    for (double& value : moved.fields[0].values) value += offset;
    const Built b = built(moved, 60);
    TetraCut cut(b.packed);
    static_cast<void>(one_shot(cut, Demand([=](const NodeFacts& facts) {
                                 return facts.range.crosses(offset + 0.3) ? 1.0 : 0.0;
                               })));
    return static_cast<double>(cut.cells().size());
  };
  const double n = n_cells(0);
  EXPECT_LT(n, static_cast<double>(mesh.tetrahedra.size()));
  EXPECT_NEAR(n_cells(0x1p27), n, 0.05 * n);
}

TEST(tetra_cut, facts_are_nested_along_discovery_which_reaches_all) {
  const Built b = built(holed_mesh(10, Cut::in_six), 100);
  const TetraCut cut(b.packed);
  std::vector<NodeId> open;
  cut.add_base(open);
  std::size_t n = 0;
  while (!open.empty()) {
    const NodeId node = open.back();
    open.pop_back();
    ++n;
    std::vector<NodeId> children;
    cut.add_children(node, children);
    for (const NodeId child : children) {
      EXPECT_LE(cut.facts(child).error, cut.facts(node).error);
      EXPECT_GE(cut.facts(child).low, cut.facts(node).low);
      EXPECT_LE(cut.facts(child).high, cut.facts(node).high);
      EXPECT_TRUE(cut.bounds(node).contains(cut.bounds(child)));
      open.push_back(child);
    }
  }
  EXPECT_EQ(n, b.hierarchy.n_nodes());
}

}  // namespace
}  // namespace lode::tetra_mt
