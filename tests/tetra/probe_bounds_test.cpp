// Bounds of values, integrals and extremes where the boundary moves, and in boxes.
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "lode/api/tetra_dataset.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/probe_checks.h"

namespace lode::test {
namespace {

TEST(tetra_probe_bounds, has_bounds_that_can_be_where_the_boundary_moves) {
  TetraMesh mesh = oracles::noise_mesh(15, oracles::Cut::in_five, 8);
  for (Vec3d& p : mesh.positions) p[2] = p[2] * (1 + 0.2 * p[0] * p[0]) + 0.1 * p[1] * p[1];
  for (double& value : mesh.fields[0].values) value += 20;
  const TetraDataset dataset = built(mesh, {.boundary_tolerance = 0.02});
  const TetraFieldInfo& info = dataset.describe().fields[0];
  for (const Box3d& box :
       {Box3d{{{0.1, 0.1, 0.1}}, {{0.9, 0.8, 0.9}}}, Box3d{{{0.3, 0.3, 0.9}}, {{0.7, 0.7, 1.3}}}}) {
    const Vec3d sizes = box.upper - box.lower;
    const double most = sizes[0] * sizes[1] * sizes[2] * (1 + 1e-9);
    const IntegralReport truth = integral_of(dataset, {.box = box, .threads = {2}});
    for (const double tolerance : {0.1, 0.5, 10.0}) {
      const IntegralReport report =
          integral_of(dataset, {.box = box, .max_error = tolerance, .threads = {2}});
      EXPECT_LE(report.volume.high, most);
      EXPECT_GE(report.volume.low, 0);
      EXPECT_GE(report.integral.low, report.volume.low * info.range_min * (1 - 1e-12));
      EXPECT_LE(report.integral.high, report.volume.high * info.range_max * (1 + 1e-12));
      expect_holds(report.volume, truth.volume.value, 1e-13, "volume");
      expect_holds(report.integral, truth.integral.value, 1e-11, "integral");
      expect_holds(report.minimum, truth.minimum.value, 1e-11, "minimum");
      expect_holds(report.maximum, truth.maximum.value, 1e-11, "maximum");
      EXPECT_GE(report.minimum.low, info.range_min);
      EXPECT_LE(report.maximum.high, info.range_max);
    }
  }
}

TEST(tetra_probe_bounds, says_where_the_boundary_may_have_moved_over_points) {
  TetraMesh mesh = oracles::noise_mesh(15, oracles::Cut::in_five, 8);
  for (Vec3d& p : mesh.positions) p[2] = p[2] * (1 + 0.2 * p[0] * p[0]) + 0.1 * p[1] * p[1];
  const TetraDataset dataset = built(mesh, {.boundary_tolerance = 0.02});
  // Just inside of faces of the reference.
  std::vector<Vec3d> points;
  std::vector<double> truths;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); i += 3)
    for (std::size_t across = 0; across < 4; ++across) {
      Vec3d p;
      double value = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const double weight = k == across ? 0.001 : 0.333;
        p = p + mesh.positions[mesh.tetrahedra[i][k]] * weight;
        value += weight * mesh.fields[0].values[mesh.tetrahedra[i][k]];
      }
      points.push_back(p);
      truths.push_back(value);
    }
  const std::size_t n_inside = points.size();
  points.push_back({{0.5, 0.5, -0.2}});
  std::vector<ProbedPoint> found;
  Progress progress;
  const auto report = dataset.probe(points, {.max_error = 10, .threads = {2}}, found, progress);
  ASSERT_TRUE(report);
  std::size_t n_near = 0;
  for (std::size_t i = 0; i < n_inside; ++i) {
    EXPECT_TRUE(found[i].is_inside || found[i].is_near_boundary) << i;
    n_near += found[i].is_near_boundary ? 1 : 0;
    EXPECT_LE(found[i].value.low, truths[i] + 1e-12);
    EXPECT_GE(found[i].value.high, truths[i] - 1e-12);
  }
  EXPECT_GT(n_near, 10U);
  EXPECT_FALSE(found.back().is_near_boundary);
  EXPECT_EQ(report->n_near_boundary, n_near);
  EXPECT_EQ(report->n_outside, 1U);
  for (const ProbedPoint& point : probed(dataset, points, 0)) EXPECT_FALSE(point.is_near_boundary);
}

TEST(tetra_probe_bounds, has_extremes_of_boxes_to_rounding_at_no_tolerance) {
  TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_six, 2);
  for (Vec3d& p : mesh.positions) p = p + Vec3d{{100, -7, 0}};
  const auto field = [](const Vec3d& p) { return 2 + 3 * p[0] - 5 * p[1] + 0.5 * p[2]; };
  set_field(mesh, field);
  const TetraDataset dataset = built(mesh);
  const Box3d box{{{100.113, -6.73, 0.31}}, {{100.77, -6.18, 0.4}}};
  const IntegralReport report = integral_of(dataset, {.box = box});
  // Values are of some 400: a rounding of one is 3e-14.
  const double lowest = field({{box.lower[0], box.upper[1], box.lower[2]}});
  const double highest = field({{box.upper[0], box.lower[1], box.upper[2]}});
  expect_holds(report.minimum, lowest, 2e-13, "minimum");
  expect_holds(report.maximum, highest, 2e-13, "maximum");
  EXPECT_LT(report.minimum.high - report.minimum.low, 1e-10);
  EXPECT_LT(report.maximum.high - report.maximum.low, 1e-10);
}

TEST(tetra_probe_bounds, has_extremes_in_the_range_where_errors_hold_everywhere) {
  const TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_five, 8);
  const TetraDataset dataset = built(mesh, {.error_place = ErrorPlace::everywhere});
  const TetraFieldInfo& info = dataset.describe().fields[0];
  const IntegralReport report = integral_of(dataset, {.max_error = 10});
  EXPECT_GT(report.probe.achieved_error, 0);
  EXPECT_EQ(report.minimum.low, info.range_min);
  EXPECT_EQ(report.maximum.high, info.range_max);
  const Box3d box{{{0.2, 0.3, 0.1}}, {{0.6, 0.5, 0.77}}};
  const IntegralReport exact = integral_of(dataset, {.box = box});
  for (const double tolerance : {0.05, 0.3, 10.0}) {
    const IntegralReport coarse = integral_of(dataset, {.box = box, .max_error = tolerance});
    expect_holds(coarse.minimum, exact.minimum.value, 1e-12, "minimum");
    expect_holds(coarse.maximum, exact.maximum.value, 1e-12, "maximum");
  }
}

}  // namespace
}  // namespace lode::test
