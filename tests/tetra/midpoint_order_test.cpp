// Edges that collapse to their midpoints in other orders than that of errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {
namespace {

using test::Tetrahedra;

constexpr std::array<CollapseOrder, 3> kAllOrders{
    CollapseOrder::squared_error, CollapseOrder::space_error, CollapseOrder::quadric};

EdgeCollapses collapsed_by(CollapseOrder order, const TetraMesh& mesh, std::uint64_t base_cells,
                           int threads = 2) {
  Progress progress;
  auto result = collapse_edges(
      mesh, {.base_cells = base_cells, .order = order, .threads = {threads}}, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : EdgeCollapses{};
}

/// A base, and its vertices with all fields, by label.
struct Base {
  Hierarchy hierarchy;
  TetraMesh vertices;
  Tetrahedra cells;
};

Base base_of(const TetraMesh& mesh, const EdgeCollapses& collapses) {
  auto hierarchy = make_hierarchy(mesh, collapses, {2});
  EXPECT_TRUE(hierarchy);
  Base base{std::move(*hierarchy), {}, {}};
  base.vertices.fields.resize(mesh.fields.size());
  for (std::uint32_t label = 0; label < base.hierarchy.n_labels(); ++label)
    for (std::size_t f = 0; f < mesh.fields.size(); ++f) {
      const Code code = base.hierarchy.code_of(label, f);
      if (f == 0) base.vertices.positions.push_back(base.hierarchy.position(label, code));
      base.vertices.fields[f].values.push_back(base.hierarchy.value(label, code, f));
    }
  base.cells = MidpointCut(Forest(base.hierarchy)).cells();
  return base;
}

/// By a search for each sample; and refined it is the reference.
void expect_true_of_base(const TetraMesh& mesh, const EdgeCollapses& collapses) {
  const Base base = base_of(mesh, collapses);
  const double volume = test::volume_of(mesh, mesh.tetrahedra);
  EXPECT_NEAR(test::expect_conforming(base.vertices, base.cells), volume, 1e-6 * volume);
  const std::size_t n = mesh.fields.size();
  for (std::size_t f = 0; f < n; ++f) {
    const auto [low, high] = std::ranges::minmax(mesh.fields[f].values);
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const test::Located found = test::locate(base.vertices, base.cells, mesh.positions[v], f);
      EXPECT_NEAR(static_cast<double>(collapses.errors[v * n + f]) * (high - low),
                  mesh.fields[f].values[v] - found.value, 1e-4 * (high - low) + 1e-12);
    }
  }
  const Forest forest(base.hierarchy);
  MidpointCut cut(forest);
  Engine<MidpointCut> engine(cut);
  engine.set_query(uniform_demand(0));
  engine.finish();
  EXPECT_EQ(test::normalised(cut.cells()),
            test::normalised(test::labelled(mesh, base.hierarchy).tetrahedra));
}

TEST(midpoint_order, whatever_it_is_errors_are_true_and_the_mesh_conforms) {
  TetraMesh mesh = oracles::noise_mesh(10, oracles::Cut::in_five, 7);
  mesh.fields.push_back(oracles::noise_mesh(10, oracles::Cut::in_five, 8).fields[0]);
  mesh.fields.push_back(mesh.fields[0]);
  std::ranges::fill(mesh.fields[2].values, -2.5);
  for (double& value : mesh.fields[1].values) value = 1e6 * value + 1e8;
  for (const CollapseOrder order : kAllOrders)
    for (const std::uint64_t base_cells : {1500U, 0U}) {
      const EdgeCollapses collapses = collapsed_by(order, mesh, base_cells);
      EXPECT_LT(collapses.n_base_cells, std::max<std::uint64_t>(base_cells + 50, 700));
      expect_true_of_base(mesh, collapses);
    }
}

TEST(midpoint_order, is_the_same_for_any_number_of_threads) {
  const TetraMesh mesh =
      oracles::noise_mesh(oracles::trials(24, 19), oracles::Cut::in_five, 5);  // several blocks
  for (const CollapseOrder order : {CollapseOrder::space_error, CollapseOrder::quadric}) {
    const EdgeCollapses one = collapsed_by(order, mesh, 10'000, 1);
    const EdgeCollapses three = collapsed_by(order, mesh, 10'000, 3);
    EXPECT_EQ(one.errors, three.errors);
    ASSERT_EQ(one.collapses.size(), three.collapses.size());
    for (std::size_t i = 0; i < one.collapses.size(); ++i) {
      EXPECT_EQ(one.collapses[i].kept, three.collapses[i].kept);
      EXPECT_EQ(one.collapses[i].removed, three.collapses[i].removed);
    }
  }
}

TEST(midpoint_order, leaves_a_box_of_a_linear_field_far_from_the_origin) {
  for (const CollapseOrder order : kAllOrders) {
    TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_five, 1);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      Vec3d& p = mesh.positions[v];
      mesh.fields[0].values[v] = 3 * p[0] - p[1] + 0.25 * p[2] + 7;
      p = 1024.0 * p + Vec3d{{1e5, -3e5, 2e5}};
    }
    const EdgeCollapses collapses = collapsed_by(order, mesh, 0);
    EXPECT_LT(collapses.n_base_cells, 60U);
    for (const float error : collapses.errors) EXPECT_LT(std::abs(error), 1e-5F);
  }
}

/// How far from its sample F' has its value, to first order: mean squares over what went.
double mean_square_distance_of(const TetraMesh& mesh, const EdgeCollapses& collapses) {
  const Base base = base_of(mesh, collapses);
  double sum = 0;
  std::size_t n = 0;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (collapses.errors[v] == 0) continue;
    const Vec3d& p = mesh.positions[v];
    const double here = test::locate(base.vertices, base.cells, p, 0).value;
    Vec3d slope;
    constexpr double kStep = 1e-5;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d beside = p;
      beside[axis] += p[axis] > 0.5 ? -kStep : kStep;
      slope[axis] = (test::locate(base.vertices, base.cells, beside, 0).value - here) / kStep;
    }
    const double distance =
        std::min(std::abs(mesh.fields[0].values[v] - here) / std::max(length(slope), 1e-9), 0.5);
    sum += distance * distance;
    ++n;
  }
  return sum / static_cast<double>(n);
}

double mean_square_of(const EdgeCollapses& collapses) {
  double sum = 0;
  for (const float e : collapses.errors) sum += static_cast<double>(e) * static_cast<double>(e);
  return sum / static_cast<double>(collapses.errors.size());
}

TEST(midpoint_order, makes_least_what_it_is_by) {
  const TetraMesh mesh = oracles::noise_mesh(13, oracles::Cut::in_five, 2);
  std::map<CollapseOrder, EdgeCollapses> by;
  for (const CollapseOrder order : kAllOrders)
    by[order] = collapsed_by(order, mesh, mesh.tetrahedra.size() * 7 / 32);
  const EdgeCollapses& by_errors = by[CollapseOrder::squared_error];
  const EdgeCollapses& by_space = by[CollapseOrder::space_error];
  const EdgeCollapses& by_quadrics = by[CollapseOrder::quadric];
  EXPECT_LT(mean_square_of(by_errors), mean_square_of(by_space));
  EXPECT_LT(mean_square_of(by_errors), mean_square_of(by_quadrics));
  EXPECT_LT(mean_square_of(by_quadrics), 4 * mean_square_of(by_errors));
  EXPECT_LT(mean_square_distance_of(mesh, by_space), mean_square_distance_of(mesh, by_errors));
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
