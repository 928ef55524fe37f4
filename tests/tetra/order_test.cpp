// Collapses in other orders than that of errors: as true, and what they are for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lode/models/tetra_mt/field_quadric.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/collapse_checks.h"
#include "tests/tetra/mesh_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Cut;
using oracles::noise_mesh;
using oracles::Random;
using test::collapsed;

constexpr std::array<CollapseOrder, 3> kOrders{CollapseOrder::squared_error,
                                               CollapseOrder::space_error, CollapseOrder::quadric};

TEST(collapse_order, whatever_it_is_errors_are_true_and_the_mesh_conforms) {
  for (const CollapseOrder order : kOrders)
    for (const double share : {0.4, 0.0}) {
      const TetraMesh mesh = noise_mesh(oracles::trials(13, 10), Cut::in_six, 3);
      const auto n = static_cast<double>(mesh.tetrahedra.size());
      const auto result =
          collapsed(mesh, static_cast<std::uint64_t>(share * n), {.order = order}, {2});
      EXPECT_LT(static_cast<double>(result.base.size()), std::max(1.01 * share, 0.1) * n);
      test::expect_simpler(mesh, result);
      test::expect_errors_true(mesh, result);
    }
}

TEST(collapse_order, takes_several_fields_some_of_them_without_range) {
  TetraMesh mesh = noise_mesh(12, Cut::in_five, 7);
  mesh.fields.push_back(noise_mesh(12, Cut::in_five, 8).fields[0]);
  mesh.fields.push_back(mesh.fields[0]);
  std::ranges::fill(mesh.fields[2].values, -2.5);
  for (double& value : mesh.fields[1].values) value = 1e6 * value + 1e8;
  for (const CollapseOrder order : kOrders) {
    const auto result = collapsed(mesh, 1500, {.order = order}, {2});
    EXPECT_LT(result.base.size(), 2000U);
    test::expect_simpler(mesh, result);
    test::expect_errors_true(mesh, result);
  }
}

/// By vertex: whether all beside it have lower values of a field, or all have higher ones.
std::vector<bool> extrema_of(const TetraMesh& mesh) {
  const std::size_t n = mesh.positions.size();
  std::vector<bool> is_one(n, false);
  for (const MeshField& field : mesh.fields) {
    std::vector<bool> has_lower(n, false);
    std::vector<bool> has_higher(n, false);
    for (const Tetrahedron& t : mesh.tetrahedra)
      for (const std::uint32_t a : t)
        for (const std::uint32_t b : t) {
          if (a == b) continue;
          has_lower[a] = has_lower[a] || field.values[b] <= field.values[a];
          has_higher[a] = has_higher[a] || field.values[b] >= field.values[a];
        }
    for (std::size_t v = 0; v < n; ++v) is_one[v] = is_one[v] || !has_lower[v] || !has_higher[v];
  }
  return is_one;
}

TEST(collapse_order, keeps_extrema_of_the_reference_where_they_are_to_stay) {
  TetraMesh mesh = noise_mesh(14, Cut::in_six, 9);
  mesh.fields.push_back(noise_mesh(14, Cut::in_six, 10).fields[0]);
  const std::vector<bool> is_extremum = extrema_of(mesh);
  for (const CollapseOrder order : kOrders) {
    const auto kept = collapsed(mesh, 0, {.order = order, .keeps_extrema = true}, {2});
    std::size_t n_gone = 0;
    for (const Collapse& collapse : kept.collapses)
      if (is_extremum[collapse.removed]) ++n_gone;
    EXPECT_EQ(n_gone, 0U);
    test::expect_simpler(mesh, kept);
    test::expect_errors_true(mesh, kept);
    // Else some go, as they are none any more, and fewer cells are left.
    const auto others = collapsed(mesh, 0, {.order = order}, {2});
    EXPECT_TRUE(std::ranges::any_of(
        others.collapses, [&](const Collapse& collapse) { return is_extremum[collapse.removed]; }));
    EXPECT_LT(others.base.size(), kept.base.size());
  }
}

TEST(collapse_order, is_the_same_for_any_number_of_threads) {
  const TetraMesh mesh = noise_mesh(oracles::trials(30, 19), Cut::in_five, 5);  // several blocks
  for (const CollapseOrder order : {CollapseOrder::space_error, CollapseOrder::quadric}) {
    const auto one = collapsed(mesh, 10'000, {.order = order}, {1});
    const auto three = collapsed(mesh, 10'000, {.order = order}, {3});
    EXPECT_EQ(test::pairs(one), test::pairs(three));
    EXPECT_EQ(one.errors, three.errors);
  }
}

TEST(collapse_order, leaves_a_box_of_a_linear_field_far_from_the_origin) {
  for (const CollapseOrder order : kOrders) {
    TetraMesh mesh = noise_mesh(9, Cut::in_five, 1);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      Vec3d& p = mesh.positions[v];
      mesh.fields[0].values[v] = 3 * p[0] - p[1] + 0.25 * p[2] + 7;
      p = 1024.0 * p + Vec3d{{1e5, -3e5, 2e5}};
    }
    const auto result = collapsed(mesh, 0, {.order = order}, {2});
    EXPECT_LT(result.base.size(), 30U);
    for (const float error : result.errors) EXPECT_LT(std::abs(error), 1e-6F);
  }
}

/// How far from its sample F' has its value, to first order: mean squares over what went.
double mean_square_distance(const TetraMesh& mesh, const HalfEdgeCollapses& result) {
  double sum = 0;
  for (const Collapse& c : result.collapses) {
    const auto& values = mesh.fields[0].values;
    const Vec3d& p = mesh.positions[c.removed];
    const double here = test::locate(mesh, result.base, p, 0).value;
    Vec3d slope;
    constexpr double kStep = 1e-5;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d beside = p;
      beside[axis] += p[axis] > 0.5 ? -kStep : kStep;
      slope[axis] = (test::locate(mesh, result.base, beside, 0).value - here) / kStep;
    }
    const double distance =
        std::min(std::abs(values[c.removed] - here) / std::max(length(slope), 1e-9), 0.5);
    sum += distance * distance;
  }
  return sum / static_cast<double>(result.collapses.size());
}

double mean_square(const std::vector<float>& errors) {
  double sum = 0;
  for (const float e : errors) sum += static_cast<double>(e) * static_cast<double>(e);
  return sum / static_cast<double>(errors.size());
}

TEST(collapse_order, makes_least_what_it_is_by) {
  const int n = oracles::trials(15, 11);
  const TetraMesh mesh = noise_mesh(n, Cut::in_five, 2);
  std::map<CollapseOrder, HalfEdgeCollapses> by;
  for (const CollapseOrder order : kOrders)
    by[order] = collapsed(mesh, mesh.tetrahedra.size() * 7 / 32, {.order = order}, {2});
  const auto& by_errors = by[CollapseOrder::squared_error];
  const auto& by_space = by[CollapseOrder::space_error];
  const auto& by_quadrics = by[CollapseOrder::quadric];
  EXPECT_LT(mean_square(by_errors.errors), mean_square(by_space.errors));
  EXPECT_LT(mean_square(by_errors.errors), mean_square(by_quadrics.errors));
  EXPECT_LT(mean_square(by_quadrics.errors), 4 * mean_square(by_errors.errors));
  EXPECT_LT(mean_square_distance(mesh, by_space), 0.9 * mean_square_distance(mesh, by_errors));
}

TEST(field_quadric, is_a_sum_of_squared_differences) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const auto number = [&] { return random.uniform(-2, 2); };
    FieldQuadric first;
    FieldQuadric second;
    const Vec3d p{{number(), number(), number()}};
    const double value = number();
    double expected = 0;
    for (int k = 0; k < 6; ++k) {
      const Vec3d gradient{{number(), number(), number()}};
      const double constant = number();
      const double weight = std::abs(number());
      (k % 2 == 0 ? first : second).add_linear(gradient, constant, weight);
      const double difference = dot(gradient, p) + constant - value;
      expected += weight * difference * difference;
    }
    first.add(second);
    EXPECT_NEAR(first.at(p, value), expected, 1e-12 * (1 + expected));
  }
}

}  // namespace
}  // namespace lode::tetra_mt
