// The space error of the paper, an estimate: how far from a vertex what replaces its tetrahedra has
// its value.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/models/tetra_mt/value_distance.h"
#include "lode/models/tetra_mt/world_codes.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::tetra_mt {
namespace {

using oracles::Random;

constexpr double kEndless = std::numeric_limits<double>::infinity();

/// Solves a system of up to 6 equations; nothing where it has no one solution.
std::optional<std::vector<double>> solved(std::vector<std::vector<double>> rows) {
  const std::size_t n = rows.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i)
      if (std::abs(rows[i][k]) > std::abs(rows[pivot][k])) pivot = i;
    if (std::abs(rows[pivot][k]) < 1e-12) return {};
    std::swap(rows[k], rows[pivot]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = rows[i][k] / rows[k][k];
      for (std::size_t j = k; j <= n; ++j) rows[i][j] -= factor * rows[k][j];
    }
  }
  std::vector<double> x(n);
  for (std::size_t k = 0; k < n; ++k) x[k] = rows[k][n] / rows[k][k];
  return x;
}

/// By the conditions of Karush, Kuhn and Tucker: of each set of corners the point that their
/// weights give which is nearest to p among those of sum 1 with the value, as far as none is
/// negative.
double distance_by_sets(const std::array<Vec3d, 4>& corners, const std::array<double, 4>& values,
                        double value, const Vec3d& p) {
  double least = kEndless;
  for (unsigned set = 1; set < 16; ++set) {
    std::vector<std::size_t> at;
    for (std::size_t k = 0; k < 4; ++k)
      if ((set >> k & 1) != 0) at.push_back(k);
    const std::size_t n = at.size();
    const bool has_value =
        std::ranges::all_of(at, [&](std::size_t k) { return values[k] == value; });
    const std::size_t n_multipliers = has_value ? 1 : 2;
    std::vector<std::vector<double>> rows(n + n_multipliers,
                                          std::vector<double>(n + n_multipliers + 1, 0));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) rows[i][j] = dot(corners[at[i]] - p, corners[at[j]] - p);
      rows[i][n] = rows[n][i] = 1;
      if (!has_value) rows[i][n + 1] = rows[n + 1][i] = values[at[i]] - value;
    }
    rows[n][n + n_multipliers] = 1;
    const auto weights = solved(rows);
    if (!weights) continue;
    Vec3d way;
    bool is_inside = true;
    for (std::size_t i = 0; i < n; ++i) {
      is_inside = is_inside && (*weights)[i] > -1e-9;
      way = way + (corners[at[i]] - p) * (*weights)[i];
    }
    if (is_inside) least = std::min(least, length(way));
  }
  return least;
}

TEST(value_distance, is_that_of_all_sets_of_corners) {
  Random random(1);
  int n_without = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::array<Vec3d, 4> corners;
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) {
      for (double& x : corners[k].v) x = random.uniform();
      // Few values, so that corners have the one that is looked for.
      values[k] = trial % 2 == 0 ? random.uniform() : 0.25 * static_cast<double>(random.below(5));
    }
    Vec3d p;
    for (double& x : p.v) x = 3 * random.uniform() - 1;
    const double value = trial % 2 == 0 ? random.uniform() : 0.5;
    const double found = distance_to_value(corners, values, value, p);
    const double expected = distance_by_sets(corners, values, value, p);
    if (expected == kEndless) ++n_without;
    // What is that flat has no one solution of some sets.
    const double volume = std::abs(
        dot(cross(corners[1] - corners[0], corners[2] - corners[0]), corners[3] - corners[0]));
    if (volume < 1e-3) continue;
    if (expected == kEndless)
      EXPECT_EQ(found, kEndless);
    else
      EXPECT_NEAR(found, expected, 1e-6) << trial;
  }
  EXPECT_GT(n_without, 1000);
}

TEST(value_distance, is_none_inside_of_a_tetrahedron_of_the_value) {
  const std::array<Vec3d, 4> corners{Vec3d{{0, 0, 0}}, Vec3d{{1, 0, 0}}, Vec3d{{0, 1, 0}},
                                     Vec3d{{0, 0, 1}}};
  const std::array<double, 4> values{2, 2, 2, 2};
  EXPECT_EQ(distance_to_value(corners, values, 2, {{0.1, 0.1, 0.1}}), 0);
  EXPECT_DOUBLE_EQ(distance_to_value(corners, values, 2, {{0.25, 0.25, -1}}), 1);
  EXPECT_EQ(distance_to_value(corners, values, 2.5, {{0.1, 0.1, 0.1}}), kEndless);
}

TEST(value_distance, of_ranges_is_that_of_their_nearest_point) {
  Random random(3);
  int n_inner = 0;
  for (int trial = 0; trial < 3'000; ++trial) {
    std::array<Vec3d, 4> corners;
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) {
      for (double& x : corners[k].v) x = random.uniform();
      values[k] = random.uniform();
    }
    Vec3d p;
    for (double& x : p.v) x = 2 * random.uniform() - 0.5;
    const Range range{random.uniform(), 0};
    const Range wide{range.low, range.low + 0.3 * random.uniform()};
    const double found = distance_to_values(corners, values, wide, p);
    // No point of the tetrahedron with these values is nearer, and one is as near.
    double least = kEndless;
    constexpr int kSteps = 24;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j)
        for (int k = 0; i + j + k <= kSteps; ++k) {
          const std::array<double, 4> shares{i / double{kSteps}, j / double{kSteps},
                                             k / double{kSteps},
                                             (kSteps - i - j - k) / double{kSteps}};
          Vec3d at;
          double value = 0;
          for (std::size_t c = 0; c < 4; ++c) {
            at = at + corners[c] * shares[c];
            value += values[c] * shares[c];
          }
          if (value >= wide.low && value <= wide.high) least = std::min(least, length(p - at));
        }
    const double ends = std::min(distance_by_sets(corners, values, wide.low, p),
                                 distance_by_sets(corners, values, wide.high, p));
    EXPECT_LE(found, std::min(least, ends) + 1e-9) << trial;
    EXPECT_GE(found, std::min(least, ends) - 0.15) << trial;
    if (found < ends - 1e-6) ++n_inner;
  }
  EXPECT_GT(n_inner, 100);
}

HalfEdgeCollapses collapsed_in_space(const TetraMesh& mesh, std::uint64_t base_cells,
                                     bool has_world_errors) {
  Progress progress;
  auto made = collapse_half_edges(
      mesh,
      {.base_cells = base_cells, .rules = {.has_world_errors = has_world_errors}, .threads = {2}},
      progress);
  EXPECT_TRUE(made);
  return std::move(*made);
}

/// A ramp beside a plateau, far from what codes say exactly.
TetraMesh plateau_mesh(double noise) {
  TetraMesh mesh = oracles::noise_mesh(13, oracles::Cut::in_six, 5);
  Random random(5);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double x = mesh.positions[v][0];
    mesh.fields[0].values[v] = 0.1 + std::max(0.0, x - 0.5) + noise * random.uniform();
  }
  return mesh;
}

TEST(world_errors, do_not_lose_values_by_rounding) {
  for (const double noise : {0.0, 1e-12, 1e-8}) {
    const TetraMesh mesh = plateau_mesh(noise);
    const auto hierarchy = make_hierarchy(mesh, collapsed_in_space(mesh, 200, true), {2});
    ASSERT_TRUE(hierarchy);
    float largest = 0;
    for (const StoredFacts& facts : hierarchy->facts)
      largest = std::max(largest, facts.world_error);
    // No cell of the reference is as long.
    EXPECT_LT(largest, 0.15F) << noise;
  }
}

TEST(world_codes, are_rounded_up_by_an_eighth_at_most_and_ascend) {
  for (const double size : {0.0, 1e-20, 0.3, 1.0, 4e6}) {
    const WorldCodes codes({{-1, 2, 0}}, {{-1, 2, size}});
    float last = -1;
    for (int code = 0; code < 256; ++code) {
      const float error = codes.error(static_cast<std::uint8_t>(code));
      EXPECT_GT(error, last);
      EXPECT_EQ(codes.code(error), code);
      last = error;
    }
    EXPECT_EQ(last, std::numeric_limits<float>::infinity());
    EXPECT_EQ(codes.error(0), 0);
    const auto diagonal = static_cast<float>(size);
    for (float x = diagonal; x > diagonal * 1e-8F; x *= 0.83F) {
      const float rounded = codes.error(codes.code(x));
      EXPECT_GE(rounded, x);
      EXPECT_LE(rounded, x * 1.1251F);
    }
  }
}

TEST(world_errors, of_a_collapse_in_the_reference_are_that_of_its_vertex_from_what_comes) {
  const TetraMesh mesh = oracles::noise_mesh(21, oracles::Cut::in_six, 7);
  const HalfEdgeCollapses collapses =
      collapsed_in_space(mesh, mesh.tetrahedra.size() * 24 / 25, true);
  const auto hierarchy = make_hierarchy(mesh, collapses, {2});
  ASSERT_TRUE(hierarchy);
  int n_looked_at = 0;
  for (std::uint32_t node = 0; node < hierarchy->n_nodes(); ++node) {
    // Of reference's tetrahedra, and all that came of it is in the base.
    if (!hierarchy->children_of(node).empty() || !hierarchy->parents_of(node).empty()) continue;
    const std::uint32_t vertex = hierarchy->n_base_vertices + node;
    const Vec3d& p = hierarchy->positions[vertex];
    const std::vector<double>& of = hierarchy->fields[0].values;
    double least = kEndless;
    double farthest = 0;
    for (std::size_t i = 0; i < hierarchy->base.size(); ++i) {
      const Tetrahedron& t = hierarchy->base[i];
      if (hierarchy->base_makers[i] != node || std::ranges::count(t, hierarchy->outside()) > 0)
        continue;
      std::array<Vec3d, 4> corners;
      std::array<double, 4> values{};
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = hierarchy->positions[t[k]];
        values[k] = of[t[k]];
        farthest = std::max(farthest, length(corners[k] - p));
      }
      // A millionth of the range, which is 1, does not count.
      for (const double value : {of[vertex], of[vertex] - kSameValue, of[vertex] + kSameValue})
        least = std::min(least, distance_by_sets(corners, values, value, p));
    }
    ++n_looked_at;
    EXPECT_NEAR(static_cast<double>(hierarchy->facts[node].world_error), std::min(least, farthest),
                1e-6)
        << node;
  }
  EXPECT_GT(n_looked_at, 50);
}

TEST(world_errors, are_nested_and_change_nothing_else) {
  const TetraMesh mesh = oracles::noise_mesh(13, oracles::Cut::in_five, 3);
  const HalfEdgeCollapses with = collapsed_in_space(mesh, 200, true);
  const HalfEdgeCollapses without = collapsed_in_space(mesh, 200, false);
  ASSERT_EQ(with.collapses.size(), without.collapses.size());
  for (std::size_t i = 0; i < with.collapses.size(); ++i) {
    EXPECT_EQ(with.collapses[i].removed, without.collapses[i].removed);
    EXPECT_EQ(with.collapses[i].kept, without.collapses[i].kept);
    EXPECT_EQ(with.facts[i].error, without.facts[i].error);
    EXPECT_EQ(without.facts[i].world_error, 0);
    if (with.facts[i].error == 0) {
      EXPECT_EQ(with.facts[i].world_error, 0);
    }
  }
  const auto hierarchy = make_hierarchy(mesh, with, {2});
  const auto none = make_hierarchy(mesh, without, {2});
  ASSERT_TRUE(hierarchy && none);
  for (std::uint32_t node = 0; node < hierarchy->n_nodes(); ++node) {
    EXPECT_EQ(none->facts[node].world_error, std::numeric_limits<float>::infinity());
    const std::uint32_t parent = hierarchy->discoverers[node];
    if (parent != kNone)
      EXPECT_GE(hierarchy->facts[parent].world_error, hierarchy->facts[node].world_error);
  }
  const auto packed = PackedHierarchy::pack(*hierarchy, mesh.tetrahedra.size(), {2});
  for (std::uint32_t node = 0; node < hierarchy->n_nodes(); ++node) {
    const float exact = hierarchy->facts[node].world_error;
    EXPECT_GE(packed.world_error(node, 0), exact);
    EXPECT_LE(packed.world_error(node, 0), 1.1251F * exact);
    // Only where they are asked for.
    EXPECT_EQ(packed.facts(node, 0).world_error, std::numeric_limits<float>::infinity());
  }
}

}  // namespace
}  // namespace lode::tetra_mt
