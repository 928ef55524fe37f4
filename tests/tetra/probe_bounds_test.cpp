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

/// Noise on a grid of sevenths, which no binary number is, turned where faces are to be oblique.
TetraMesh noise_of_sevenths(bool is_turned) {
  TetraMesh mesh = oracles::noise_mesh(8, oracles::Cut::in_five, 5);
  if (is_turned)
    for (Vec3d& p : mesh.positions)
      p = {{0.6 * p[0] - 0.8 * p[1] + 3, 0.48 * p[0] + 0.36 * p[1] - 0.8 * p[2],
            0.64 * p[0] + 0.48 * p[1] + 0.6 * p[2]}};
  return mesh;
}

double volume_of(const TetraMesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.tetrahedra) {
    const Vec3d& a = mesh.positions[t[0]];
    volume +=
        dot(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a), mesh.positions[t[3]] - a) /
        6;
  }
  return volume;
}

/// Middles of faces of all cells, those of the boundary among them.
std::vector<Vec3d> face_middles(const TetraMesh& mesh) {
  std::vector<Vec3d> middles;
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t k = 0; k < 4; ++k)
      middles.push_back(
          (mesh.positions[t[k]] + mesh.positions[t[(k + 1) % 4]] + mesh.positions[t[(k + 2) % 4]]) *
          (1.0 / 3));
  return middles;
}

TEST(tetra_probe_bounds, has_no_point_of_the_mesh_outside) {
  for (const bool is_turned : {false, true})
    for (const Placement placement : {Placement::half_edge, Placement::midpoint}) {
      const TetraMesh mesh = noise_of_sevenths(is_turned);
      const TetraDataset dataset = built(mesh, {.base_share = 0, .placement = placement});
      for (const ProbedPoint& point : probed(dataset, face_middles(mesh), 0))
        EXPECT_TRUE(point.is_inside) << point.point[0] << ' ' << point.point[1];
      for (const double tolerance : {0.1, 0.5, 10.0}) {
        const auto found = probed(dataset, mesh.positions, tolerance);
        for (std::size_t v = 0; v < found.size(); ++v) {
          ASSERT_TRUE(found[v].is_inside || found[v].is_near_boundary) << v;
          EXPECT_LE(found[v].value.low, mesh.fields[0].values[v] + 1e-12);
          EXPECT_GE(found[v].value.high, mesh.fields[0].values[v] - 1e-12);
        }
      }
    }
}

TEST(tetra_probe_bounds, snaps_points_to_what_is_near) {
  TetraMesh mesh = noise_of_sevenths(false);
  set_field(mesh, [](const Vec3d& p) { return p[0] + 2 * p[1]; });
  const TetraDataset dataset = built(mesh);
  const std::vector<Vec3d> points{{{-0.01, 0.3, 0.4}}, {{-0.03, 0.3, 0.4}}, {{0.5, 0.5, 1.0199}}};
  Progress progress;
  std::vector<ProbedPoint> found;
  const auto report = dataset.probe(points, {.snap = 0.02, .threads = {2}}, found, progress);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->n_outside, 1U);
  EXPECT_TRUE(found[0].is_inside && !found[1].is_inside && found[2].is_inside);
  for (const std::size_t i : {0U, 2U}) {
    // Of the nearest point, (0, 0.3, 0.4) or (0.5, 0.5, 1).
    EXPECT_NEAR(found[i].value.value, i == 0 ? 0.6 : 1.5, 1e-12);
    expect_holds(found[i].value, i == 0 ? 0.6 : 1.5, 0, "value");
    EXPECT_LT(found[i].value.high - found[i].value.low, 1e-11);
    EXPECT_NEAR(found[i].snapped, i == 0 ? 0.01 : 0.0199, 1e-12);
  }
  for (const ProbedPoint& point : probed(dataset, points, 0)) EXPECT_FALSE(point.is_inside);
  EXPECT_FALSE(dataset.probe(points, {.snap = -1}, found, progress));
}

TEST(tetra_probe_bounds, has_volumes_that_hold_where_middles_are_rounded) {
  for (const bool is_turned : {false, true}) {
    const TetraMesh mesh = noise_of_sevenths(is_turned);
    const TetraDataset dataset = built(mesh, {.base_share = 0, .placement = Placement::midpoint});
    for (const double tolerance : {0.0, 0.1, 0.5, 10.0}) {
      const IntegralReport report = integral_of(dataset, {.max_error = tolerance, .threads = {2}});
      expect_holds(report.volume, volume_of(mesh), 1e-14, "volume");
      EXPECT_LT(report.volume.high - report.volume.low, is_turned ? 1e-6 : 1e-8);
    }
  }
}

/// A vertex inside is moved through the cells beside it, so that some are folded over others.
TEST(tetra_probe_bounds, has_volumes_that_hold_where_cells_are_folded) {
  TetraMesh mesh = noise_of_sevenths(false);
  for (double& value : mesh.fields[0].values) value += 1000;
  const Vec3d middle{{3.0 / 7, 3.0 / 7, 3.0 / 7}};
  for (Vec3d& p : mesh.positions)
    if (length(p - middle) < 1e-9) p = p + Vec3d{{0.17, 0.03, 0.02}};
  for (const Placement placement : {Placement::half_edge, Placement::midpoint}) {
    const TetraDataset dataset = built(mesh, {.base_share = 0, .placement = placement});
    for (const double tolerance : {0.0, 0.1, 0.5, 10.0}) {
      const IntegralReport report = integral_of(dataset, {.max_error = tolerance, .threads = {2}});
      expect_holds(report.volume, 1, 1e-14, "volume");
    }
  }
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
