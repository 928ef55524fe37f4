// Values, profiles and integrals of meshes of tetrahedra, against looks at all cells of the mesh
// that was read.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "lode/api/tetra_dataset.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/probe_checks.h"

namespace lode {
namespace {

using oracles::Random;
using test::built;
using test::expect_holds;
using test::integral_of;
using test::probed;
using test::set_field;

/// Noise in a cube with a cavity, in two regions.
TetraMesh noise_with_cavity(int n) {
  TetraMesh mesh = oracles::noise_mesh(n, oracles::Cut::in_five, 21);
  const auto centre_of = [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return centre;
  };
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    return length(centre_of(t) - Vec3d{{0.5, 0.5, 0.4}}) < 0.2;
  });
  mesh.region_ids = {3, 8};
  for (const auto& t : mesh.tetrahedra) mesh.regions.push_back(centre_of(t)[0] < 0.4 ? 0 : 1);
  return mesh;
}

/// What a look at all cells says of a point.
struct Seen {
  double least = -std::numeric_limits<double>::infinity();  ///< Of the weights, at best.
  double value = 0;
};
Seen look_everywhere(const TetraMesh& mesh, const Vec3d& p) {
  Seen best;
  for (const auto& t : mesh.tetrahedra) {
    std::array<Vec3d, 4> c;
    for (std::size_t k = 0; k < 4; ++k) c[k] = mesh.positions[t[k]];
    const auto volume = [](const std::array<Vec3d, 4>& q) {
      return dot(cross(q[1] - q[0], q[2] - q[0]), q[3] - q[0]);
    };
    Seen here{std::numeric_limits<double>::infinity(), 0};
    for (std::size_t k = 0; k < 4; ++k) {
      auto part = c;
      part[k] = p;
      const double weight = volume(part) / volume(c);
      here.least = std::min(here.least, weight);
      here.value += weight * mesh.fields[0].values[t[k]];
    }
    if (here.least > best.least) best = here;
  }
  return best;
}

/// Anywhere, and on vertices, edges and faces.
std::vector<Vec3d> points_of(const TetraMesh& mesh, std::uint64_t seed, int n) {
  Random random(seed);
  std::vector<Vec3d> points;
  for (int i = 0; i < n; ++i) {
    const auto& t = mesh.tetrahedra[random.below(mesh.tetrahedra.size())];
    const Vec3d& a = mesh.positions[t[0]];
    const Vec3d& b = mesh.positions[t[1]];
    const Vec3d& c = mesh.positions[t[2]];
    switch (i % 5) {
      case 0: points.push_back(a); break;
      case 1: points.push_back((a + b) * 0.5); break;
      case 2: points.push_back(a * 0.25 + b * 0.25 + c * 0.5); break;
      default:
        points.push_back(
            {{random.uniform(-0.1, 1.1), random.uniform(-0.1, 1.1), random.uniform(-0.1, 1.1)}});
    }
  }
  return points;
}

TEST(tetra_probe, gives_the_reference_values_at_no_tolerance) {
  const TetraMesh mesh = noise_with_cavity(11);
  const TetraDataset dataset = built(mesh);
  const std::vector<Vec3d> points = points_of(mesh, 5, 600);
  const std::vector<ProbedPoint> found = probed(dataset, points, 0);
  std::size_t n_outside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Seen truth = look_everywhere(mesh, points[i]);
    EXPECT_EQ(found[i].point, points[i]);
    if (std::abs(truth.least) > 1e-12) EXPECT_EQ(found[i].is_inside, truth.least > 0) << i;
    // Vertices are held by their cells, whatever rounding says.
    if (i % 5 == 0) EXPECT_TRUE(found[i].is_inside);
    n_outside += found[i].is_inside ? 0 : 1;
    if (!found[i].is_inside) continue;
    EXPECT_TRUE(found[i].is_exact);
    EXPECT_EQ(found[i].error, 0);
    // Cells are well-shaped: a weight is off by some 1e-15.
    expect_holds(found[i].value, truth.value, 1e-13, "value");
    EXPECT_LT(found[i].value.high - found[i].value.low, 1e-11);
    if (points[i][0] < 0.3) EXPECT_EQ(found[i].region, 3);
    if (points[i][0] > 0.5) EXPECT_EQ(found[i].region, 8);
  }
  EXPECT_GT(n_outside, 50U);
}

TEST(tetra_probe, has_bounds_that_hold_at_any_tolerance) {
  const TetraMesh mesh = noise_with_cavity(13);
  const TetraDataset dataset = built(mesh);
  const TetraFieldInfo& info = dataset.describe().fields[0];
  const double range = info.range_max - info.range_min;
  const std::vector<Vec3d> points = points_of(mesh, 6, 500);
  std::vector<Seen> truths;
  for (const Vec3d& p : points) truths.push_back(look_everywhere(mesh, p));
  for (const double share : {1.0, 0.2, 0.05, 0.01}) {
    const std::vector<ProbedPoint> found = probed(dataset, points, share * range);
    std::size_t n_coarse = 0;
    double width = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (std::abs(truths[i].least) > 1e-9) EXPECT_EQ(found[i].is_inside, truths[i].least > 0);
      if (!found[i].is_inside) continue;
      expect_holds(found[i].value, truths[i].value, 1e-13, "value");
      // At samples the stated error holds, too.
      if (i % 5 == 0)
        EXPECT_LE(std::abs(found[i].value.value - truths[i].value), found[i].error + 1e-12);
      EXPECT_LE(found[i].error, share * range);
      n_coarse += found[i].is_exact ? 0 : 1;
      width = std::max(width, found[i].value.high - found[i].value.low);
    }
    EXPECT_GT(n_coarse, 20U);
    EXPECT_LE(width, range * 1.001);
  }
}

TEST(tetra_probe, reads_little_of_a_file_and_gives_what_memory_gives) {
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("lode_probe_{}.lode", ::getpid()))
          .string();
  const TetraMesh mesh = oracles::noise_mesh(33, oracles::Cut::in_five, 4);
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(mesh, path, {}, progress));
  const auto opened = TetraDataset::open(path);
  ASSERT_TRUE(opened);
  const std::vector<Vec3d> one{{{0.31, 0.62, 0.47}}};
  const auto coarse = probed(*opened, one, 0.2);
  EXPECT_LT(opened->reads().n_bytes, opened->reads().file_size / 4);
  const auto from_file = probed(*opened, one, 0);
  EXPECT_LT(opened->reads().n_bytes, opened->reads().file_size);
  const TetraDataset dataset = built(mesh);
  const auto from_memory = probed(dataset, one, 0);
  EXPECT_EQ(from_file[0].value.value, from_memory[0].value.value);
  EXPECT_EQ(coarse[0].value.low, probed(dataset, one, 0.2)[0].value.low);
  EXPECT_TRUE(from_file[0].is_exact);
  EXPECT_NEAR(from_file[0].value.value, look_everywhere(mesh, one[0]).value, 1e-12);
  std::filesystem::remove(path);
}

TEST(tetra_probe, is_exact_for_linear_fields_at_any_tolerance) {
  TetraMesh mesh = noise_with_cavity(11);
  const auto field = [](const Vec3d& p) { return 2 + 3 * p[0] - 5 * p[1] + 0.5 * p[2]; };
  set_field(mesh, field);
  const TetraDataset dataset = built(mesh);
  for (const double tolerance : {0.0, 0.1, 100.0})
    for (const ProbedPoint& point : probed(dataset, points_of(mesh, 7, 200), tolerance))
      if (point.is_inside) {
        EXPECT_NEAR(point.value.value, field(point.point), 1e-12);
        expect_holds(point.value, field(point.point), 1e-13, "value");
      }
}

TEST(tetra_probe, follows_lines_from_face_to_face_and_across_cavities) {
  const TetraMesh mesh = noise_with_cavity(11);
  const TetraDataset dataset = built(mesh);
  Progress progress;
  struct Case {
    Vec3d begin;
    Vec3d end;
    std::uint32_t n_parts;
  };
  // Askew, along an axis through the cavity, along edges of cells, in the boundary.
  for (const auto& [begin, end, n_parts] :
       {Case{{{-0.2, 0.13, 0.04}}, {{1.3, 0.71, 0.93}}, 0},
        Case{{{-0.5, 0.5, 0.4}}, {{2, 0.5, 0.4}}, 2}, Case{{{0, 0.3, 0.1}}, {{1, 0.3, 0.1}}, 1},
        Case{{{0.11, 0, -1}}, {{0.11, 0, 1}}, 1}, Case{{{2, 0, 0}}, {{3, 1, 1}}, 0},
        Case{{{0.21, 0.22, 0.93}}, {{0.211, 0.22, 0.93}}, 1}}) {
    std::vector<ProbedLinePoint> knots;
    ASSERT_TRUE(
        dataset.probe_line({.begin = begin, .end = end}, {.threads = {2}}, knots, progress));
    const double size = length(end - begin);
    double inside = 0;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      const ProbedLinePoint& knot = knots[i];
      EXPECT_TRUE(knot.at.is_inside);
      EXPECT_NEAR(length(knot.at.point - (begin + (end - begin) * (knot.distance / size))), 0,
                  1e-12);
      expect_holds(knot.at.value, look_everywhere(mesh, knot.at.point).value, 1e-11, "knot");
      if (i == 0 || knots[i - 1].part != knot.part) continue;
      EXPECT_GT(knot.distance, knots[i - 1].distance);
      inside += knot.distance - knots[i - 1].distance;
      // Linear between knots.
      for (const double t : {0.25, 0.7}) {
        const Vec3d p = knots[i - 1].at.point * (1 - t) + knot.at.point * t;
        const double linear = knots[i - 1].at.value.value * (1 - t) + knot.at.value.value * t;
        EXPECT_NEAR(linear, look_everywhere(mesh, p).value, 1e-11);
      }
    }
    if (n_parts > 0) EXPECT_EQ(knots.back().part + 1, n_parts);
    // As long inside as many points say.
    std::vector<ProbedLinePoint> samples;
    ASSERT_TRUE(dataset.probe_line({.begin = begin, .end = end, .n_points = 2001}, {.threads = {2}},
                                   samples, progress));
    ASSERT_EQ(samples.size(), 2001U);
    EXPECT_EQ(samples.back().at.point, end);
    const auto n_inside = static_cast<double>(
        std::ranges::count_if(samples, [](const auto& s) { return s.at.is_inside; }));
    EXPECT_NEAR(inside, n_inside / 2001 * size, 3 * size / 2001);
  }
}

TEST(tetra_probe, has_profiles_within_bounds_at_any_tolerance) {
  const TetraMesh mesh = noise_with_cavity(13);
  const TetraDataset dataset = built(mesh);
  Progress progress;
  std::size_t n_exact = 0;
  for (const double tolerance : {0.0, 0.1, 0.5}) {
    std::vector<ProbedLinePoint> knots;
    ASSERT_TRUE(dataset.probe_line({.begin = {{0.02, 0.9, 0.1}}, .end = {{0.97, 0.2, 0.95}}},
                                   {.max_error = tolerance, .threads = {2}}, knots, progress));
    if (tolerance == 0) n_exact = knots.size();
    if (tolerance == 0.5) EXPECT_LT(knots.size(), n_exact);
    for (const ProbedLinePoint& knot : knots)
      expect_holds(knot.at.value, look_everywhere(mesh, knot.at.point).value, 1e-11, "knot");
  }
}

/// By all cells of the reference, whole.
struct Whole {
  double volume = 0;
  double integral = 0;
};
Whole sum_over_cells(const TetraMesh& mesh, std::optional<std::uint32_t> region = {}) {
  Whole sum;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    if (region && mesh.regions[i] != *region) continue;
    const auto& [a, b, c, d] = mesh.tetrahedra[i];
    const auto& p = mesh.positions;
    const auto& f = mesh.fields[0].values;
    const double volume = dot(cross(p[b] - p[a], p[c] - p[a]), p[d] - p[a]) / 6;
    sum.volume += volume;
    sum.integral += volume * (f[a] + f[b] + f[c] + f[d]) / 4;
  }
  return sum;
}

TEST(tetra_probe, integrates_over_the_domain_and_its_regions) {
  const TetraMesh mesh = noise_with_cavity(12);
  const TetraDataset dataset = built(mesh);
  for (const std::vector<std::int64_t>& regions : {std::vector<std::int64_t>{}, {3}, {8}, {8, 3}}) {
    const Whole truth =
        regions.size() == 1 ? sum_over_cells(mesh, regions[0] == 3 ? 0 : 1) : sum_over_cells(mesh);
    for (const double tolerance : {0.0, 0.02, 0.3, 10.0}) {
      const IntegralReport report =
          integral_of(dataset, {.regions = regions, .max_error = tolerance, .threads = {2}});
      // Sums of ten thousand terms of one size.
      expect_holds(report.volume, truth.volume, 1e-13, "volume");
      expect_holds(report.integral, truth.integral, 1e-13, "integral");
      expect_holds(report.mean, truth.integral / truth.volume, 1e-12, "mean");
      if (tolerance > 0) continue;
      EXPECT_LT(report.volume.high - report.volume.low, 1e-10);
      EXPECT_LT(report.integral.high - report.integral.low, 1e-10);
      EXPECT_LE(report.volume_rounding, 1e-10);
      EXPECT_EQ(report.integral_estimate, 0);
      if (regions.size() != 1) {
        EXPECT_EQ(report.n_cells, mesh.tetrahedra.size());
        EXPECT_EQ(report.minimum.value, dataset.describe().fields[0].range_min);
        EXPECT_EQ(report.maximum.value, dataset.describe().fields[0].range_max);
        EXPECT_EQ(report.minimum.low, report.minimum.high);
      }
    }
  }
  Progress progress;
  EXPECT_FALSE(dataset.integrate({.regions = {4}}, progress));
}

TEST(tetra_probe, integrates_over_boxes_as_sums_over_parts_say) {
  const TetraMesh mesh = noise_with_cavity(11);
  const TetraDataset dataset = built(mesh);
  const Whole truth = sum_over_cells(mesh);
  // Planes anywhere, at vertices, and beyond the domain.
  const std::array<double, 4> planes{-0.5, 0.37, 0.6, 1.5};
  double volume = 0;
  double integral = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 27; ++n) {
    Box3d box;
    for (std::size_t i = 0, k = static_cast<std::size_t>(n); i < 3; ++i, k /= 3) {
      box.lower[i] = planes[k % 3];
      box.upper[i] = planes[k % 3 + 1];
    }
    const IntegralReport exact = integral_of(dataset, {.box = box, .threads = {2}});
    volume += exact.volume.value;
    integral += exact.integral.value;
    least = std::min(least, exact.minimum.value);
    for (const double tolerance : {0.05, 0.4}) {
      const IntegralReport coarse =
          integral_of(dataset, {.box = box, .max_error = tolerance, .threads = {2}});
      expect_holds(coarse.volume, exact.volume.value, 1e-13, "volume");
      expect_holds(coarse.integral, exact.integral.value, 1e-13, "integral");
      expect_holds(coarse.mean, exact.mean.value, 1e-12, "mean");
      expect_holds(coarse.minimum, exact.minimum.value, 1e-12, "minimum");
      expect_holds(coarse.maximum, exact.maximum.value, 1e-12, "maximum");
    }
  }
  EXPECT_NEAR(volume, truth.volume, 1e-13);
  EXPECT_NEAR(integral, truth.integral, 1e-13);
  EXPECT_EQ(least, dataset.describe().fields[0].range_min);
  EXPECT_TRUE(integral_of(dataset, {.box = Box3d{{{2, 0, 0}}, {{3, 1, 1}}}}).is_empty);
}

TEST(tetra_probe, knows_integrals_of_linear_fields_over_boxes) {
  TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_six, 2);
  const auto field = [](const Vec3d& p) { return 2 + 3 * p[0] - 5 * p[1] + 0.5 * p[2]; };
  set_field(mesh, field);
  const TetraDataset dataset = built(mesh);
  const Box3d box{{{0.113, 0.27, 0.31}}, {{0.77, 0.82, 0.4}}};
  const Vec3d sizes = box.upper - box.lower;
  const double volume = sizes[0] * sizes[1] * sizes[2];
  const double integral = volume * field((box.lower + box.upper) * 0.5);
  for (const double tolerance : {0.0, 0.1, 10.0}) {
    const IntegralReport report = integral_of(dataset, {.box = box, .max_error = tolerance});
    EXPECT_NEAR(report.volume.value, volume, 1e-14);
    EXPECT_NEAR(report.integral.value, integral, 1e-14);
    expect_holds(report.integral, integral, 0, "integral");
    EXPECT_NEAR(report.minimum.value, field({{box.lower[0], box.upper[1], box.lower[2]}}), 1e-12);
    EXPECT_NEAR(report.maximum.value, field({{box.upper[0], box.lower[1], box.upper[2]}}), 1e-12);
  }
}

TEST(tetra_probe, has_volumes_within_bounds_where_the_boundary_moves) {
  TetraMesh mesh = oracles::noise_mesh(15, oracles::Cut::in_five, 8);
  // A curved boundary.
  for (Vec3d& p : mesh.positions) p[2] = p[2] * (1 + 0.2 * p[0] * p[0]) + 0.1 * p[1] * p[1];
  const Whole truth = sum_over_cells(mesh);
  const TetraDataset dataset = built(mesh, {.boundary_tolerance = 0.01});
  EXPECT_GT(dataset.describe().boundary_deviation, 1e-4);
  const IntegralReport report = integral_of(dataset, {.max_error = 10});
  EXPECT_GT(std::abs(report.volume.value - truth.volume), 1e-6);
  expect_holds(report.volume, truth.volume, 0, "volume");
  expect_holds(report.integral, truth.integral, 0, "integral");
  const IntegralReport exact = integral_of(dataset, {});
  EXPECT_NEAR(exact.volume.value, truth.volume, 1e-13);
  EXPECT_LT(exact.volume.high - exact.volume.low, 1e-10);
}

TEST(tetra_probe, is_the_same_for_any_number_of_threads) {
  const TetraMesh mesh = noise_with_cavity(11);
  const TetraDataset dataset = built(mesh);
  const std::vector<Vec3d> points = points_of(mesh, 9, 300);
  const auto one = probed(dataset, points, 0.1, 1);
  const auto three = probed(dataset, points, 0.1, 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(one[i].is_inside, three[i].is_inside);
    EXPECT_EQ(one[i].value.value, three[i].value.value);
    EXPECT_EQ(one[i].value.low, three[i].value.low);
  }
  const IntegralReport a = integral_of(dataset, {.max_error = 0.1, .threads = {1}});
  const IntegralReport b = integral_of(dataset, {.max_error = 0.1, .threads = {3}});
  EXPECT_EQ(a.integral.value, b.integral.value);
  EXPECT_EQ(a.integral.low, b.integral.low);
  EXPECT_EQ(a.volume_rounding, b.volume_rounding);
}

TEST(tetra_probe, refuses_what_has_no_answer) {
  const TetraDataset dataset = built(noise_with_cavity(7));
  Progress progress;
  std::vector<ProbedPoint> points;
  std::vector<ProbedLinePoint> line;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Vec3d> bad{{{0, 0, 0}}, {{nan, 0, 0}}};
  EXPECT_FALSE(dataset.probe(bad, {}, points, progress));
  EXPECT_FALSE(dataset.probe({}, {.max_error = -1}, points, progress));
  EXPECT_FALSE(dataset.probe({}, {.max_error = nan}, points, progress));
  EXPECT_TRUE(dataset.probe({}, {}, points, progress));
  EXPECT_TRUE(points.empty());
  EXPECT_FALSE(dataset.probe_line({}, {}, line, progress));
  EXPECT_FALSE(dataset.probe_line({.end = {{1, 0, 0}}, .n_points = 1}, {}, line, progress));
  EXPECT_FALSE(dataset.integrate({.box = Box3d{{{1, 0, 0}}, {{0, 1, 1}}}}, progress));
}

}  // namespace
}  // namespace lode
