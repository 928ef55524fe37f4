// Values, profiles and integrals of volumes, against the field as its cells define it, and against
// sums over the meshes that are extracted of it.
#include <fmt/format.h>

#include <filesystem>
#include <random>

#include "lode/api/probe.h"
#include "lode/mappers/cell_part.h"
#include "tests/models/built_dataset.h"
#include "tests/models/mesh_fixtures.h"
#include "tests/models/volume_files.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using test::awkward_grid;
using test::built_dataset;
using test::field_at;
using test::holed_volume;
using test::noisy_volume;
using test::plain_grid;

constexpr double kRounding = 1e-11;

/// Anywhere in the grid and a little outside, and at samples, on edges and in faces of its cells.
std::vector<Vec3d> points_of(const RegularGrid& grid, std::uint32_t seed, int n) {
  std::mt19937 random(seed);
  const auto share = [&] { return std::generate_canonical<double, 32>(random); };
  std::vector<Vec3d> points;
  for (int i = 0; i < n; ++i) {
    Vec3d index;
    for (std::size_t a = 0; a < 3; ++a) {
      const double size = grid.dims[a] - 1;
      index[a] = i % 4 == 0 ? std::floor(share() * (size + 1)) : -0.5 + share() * (size + 1);
      if (i % 4 == 1) index[a] = std::floor(2 * share() * size) / 2;
    }
    points.push_back(grid.to_world(index));
  }
  return points;
}

std::vector<ProbedPoint> probed(const Dataset& dataset, const std::vector<Vec3d>& points,
                                const ProbeOptions& options) {
  Progress progress;
  std::vector<ProbedPoint> found;
  const auto report = dataset.probe(points, options, found, progress);
  EXPECT_TRUE(report) << report.error().message;
  EXPECT_LE(report->achieved_error, options.max_error);
  return found;
}

IntegralReport integral_of(const Dataset& dataset, const IntegralOptions& options) {
  Progress progress;
  const auto report = dataset.integrate(options, progress);
  EXPECT_TRUE(report) << report.error().message;
  return *report;
}

void expect_holds(const BoundedNumber& number, double truth, double rounding) {
  EXPECT_LE(number.low, number.value);
  EXPECT_LE(number.value, number.high);
  EXPECT_LE(number.low, truth + rounding);
  EXPECT_GE(number.high, truth - rounding);
}

bool is_inside(const RegularGrid& grid, const Vec3d& world, double margin) {
  const Vec3d index = grid.to_index(world);
  for (std::size_t a = 0; a < 3; ++a)
    if (index[a] < -margin || index[a] > grid.dims[a] - 1 + margin) return false;
  return true;
}

TEST(volume_probe, gives_the_field_at_full_resolution) {
  for (const RegularGrid& grid :
       {plain_grid({{18, 11, 6}}), awkward_grid({{9, 17, 13}}), plain_grid({{2, 2, 2}})}) {
    const Volume volume = noisy_volume(grid, 3);
    const std::vector<Vec3d> points = points_of(grid, 5, 800);
    const std::vector<ProbedPoint> found = probed(built_dataset(volume), points, {});
    std::size_t n_inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      SCOPED_TRACE(i);
      EXPECT_EQ(found[i].point, points[i]);
      if (is_inside(grid, points[i], 1e-9) == is_inside(grid, points[i], -1e-9))
        EXPECT_EQ(found[i].is_inside, is_inside(grid, points[i], 0));
      // Samples are inside, whatever rounding says.
      if (i % 4 == 0) EXPECT_TRUE(found[i].is_inside);
      if (!found[i].is_inside) continue;
      ++n_inside;
      EXPECT_TRUE(found[i].is_exact);
      EXPECT_EQ(found[i].error, 0);
      if (is_inside(grid, points[i], 0))
        expect_holds(found[i].value, field_at(volume, points[i]), kRounding);
      EXPECT_LT(found[i].value.high - found[i].value.low, 1e-9);
    }
    EXPECT_GT(n_inside, 300U);
    EXPECT_LT(n_inside, 800U);
  }
}

TEST(volume_probe, has_bounds_that_hold_at_any_tolerance) {
  for (const RegularGrid& grid : {plain_grid({{37, 29, 22}}), awkward_grid({{33, 20, 27}})}) {
    const Volume volume = noisy_volume(grid, 4);
    const Dataset dataset = built_dataset(volume);
    const std::vector<Vec3d> points = points_of(grid, 6, 200);
    for (const double tolerance : {60.0, 25.0, 12.0, 6.0}) {
      std::size_t n_coarse = 0;
      const auto found = probed(dataset, points, {.max_error = tolerance});
      for (std::size_t i = 0; i < points.size(); ++i) {
        SCOPED_TRACE(i);
        if (!is_inside(grid, points[i], -1e-9)) continue;
        ASSERT_TRUE(found[i].is_inside);
        const double truth = field_at(volume, points[i]);
        expect_holds(found[i].value, truth, kRounding);
        EXPECT_LE(found[i].error, tolerance);
        EXPECT_LE(std::abs(found[i].value.value - truth), found[i].error + kRounding);
        n_coarse += found[i].is_exact ? 0 : 1;
      }
      EXPECT_GT(n_coarse, 20U) << tolerance;
    }
  }
}

TEST(volume_probe, takes_points_in_cells_with_holes_for_outside) {
  const Volume volume = holed_volume(awkward_grid({{21, 18, 15}}), 9);
  const Dataset dataset = built_dataset(volume);
  const std::vector<Vec3d> points = points_of(volume.info.grid, 7, 600);
  for (const double tolerance : {0.0, 10.0, 50.0}) {
    const auto found = probed(dataset, points, {.max_error = tolerance});
    std::size_t n_holes = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      SCOPED_TRACE(i);
      // What lies between cells has the value of the one that is there.
      if (i % 4 < 2 || !is_inside(volume.info.grid, points[i], -1e-9)) continue;
      const double truth = field_at(volume, points[i]);
      ASSERT_EQ(found[i].is_inside, !std::isnan(truth));
      n_holes += std::isnan(truth) ? 1 : 0;
      if (found[i].is_inside) expect_holds(found[i].value, truth, kRounding);
    }
    EXPECT_GT(n_holes, 10U);
  }
}

TEST(volume_probe, follows_lines_from_face_to_face) {
  const Volume volume = noisy_volume(awkward_grid({{15, 12, 10}}), 8);
  const RegularGrid& grid = volume.info.grid;
  const Dataset dataset = built_dataset(volume);
  const ProbedLine line{grid.to_world({{-3, 1.3, 2.2}}), grid.to_world({{20, 9.1, 7.9}})};
  Progress progress;
  for (const double tolerance : {0.0, 12.0}) {
    std::vector<ProbedLinePoint> found;
    ASSERT_TRUE(dataset.probe_line(line, {.max_error = tolerance}, found, progress));
    ASSERT_GT(found.size(), 5U);
    for (std::size_t i = 1; i < found.size(); ++i) {
      EXPECT_GT(found[i].distance, found[i - 1].distance);
      // In between it is linear, at no tolerance.
      const Vec3d middle = (found[i].at.point + found[i - 1].at.point) * 0.5;
      const double mean = (found[i].at.value.value + found[i - 1].at.value.value) / 2;
      EXPECT_NEAR(mean, field_at(volume, middle), tolerance + 1e-9);
    }
    for (const ProbedLinePoint& point : found)
      if (is_inside(grid, point.at.point, -1e-9))
        expect_holds(point.at.value, field_at(volume, point.at.point), kRounding);
  }
  std::vector<ProbedLinePoint> found;
  ASSERT_TRUE(dataset.probe_line({line.begin, line.end, 101}, {}, found, progress));
  ASSERT_EQ(found.size(), 101U);
  EXPECT_FALSE(found.front().at.is_inside);
  EXPECT_TRUE(found[50].at.is_inside);
}

/// What a mesh's tetrahedra have in a box.
struct Summed {
  double volume = 0;
  double integral = 0;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
};
Summed sum_of(const SimplexMesh& mesh, const std::optional<Box3d>& box) {
  Summed sum;
  for (const auto& t : mesh.tetrahedra) {
    std::array<Vec3d, 4> corners;
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = mesh.positions[t[k]];
      values[k] = mesh.values[t[k]];
    }
    const CellPart part = part_in_box(corners, values, box);
    if (part.volume == 0) continue;
    sum.volume += part.volume;
    sum.integral += part.integral;
    sum.lowest = std::min(sum.lowest, part.lowest);
    sum.highest = std::max(sum.highest, part.highest);
  }
  return sum;
}

/// None, one in the middle, one along planes of samples of a plain grid, and one of a part of a
/// cell.
std::vector<std::optional<Box3d>> boxes_in(const RegularGrid& grid) {
  const Box3d all = grid.world_bounds();
  const Vec3d size = all.upper - all.lower;
  const auto at = [&](double x, double y, double z) {
    return all.lower + Vec3d{{x * size[0], y * size[1], z * size[2]}};
  };
  return {std::nullopt, Box3d{at(0.21, 0.33, 0.4), at(0.77, 0.81, 0.62)},
          Box3d{{{2, 3, 1}}, {{7, 9, 4}}}, Box3d{at(0.5, 0.5, 0.5), at(0.501, 0.502, 0.503)},
          Box3d{at(-1, -1, -1), at(0.5, 2, 2)}};
}

void expect_sums(const IntegralReport& report, const Summed& truth) {
  ASSERT_EQ(report.is_empty, truth.volume == 0);
  if (report.is_empty) return;
  const double scale = truth.volume * std::max(std::abs(truth.lowest), std::abs(truth.highest));
  expect_holds(report.volume, truth.volume, 1e-11 * truth.volume);
  expect_holds(report.integral, truth.integral, 1e-11 * scale);
  expect_holds(report.mean, truth.integral / truth.volume, 1e-11 * scale / truth.volume);
  expect_holds(report.minimum, truth.lowest, 1e-9);
  expect_holds(report.maximum, truth.highest, 1e-9);
}

TEST(volume_integral, is_that_of_the_tetrahedra) {
  std::size_t n_empty = 0;
  for (const Volume& volume :
       {noisy_volume(plain_grid({{18, 11, 6}}), 1), noisy_volume(awkward_grid({{140, 9, 7}}), 2),
        holed_volume(awkward_grid({{12, 17, 13}}), 3), holed_volume(plain_grid({{9, 8, 20}}), 4),
        noisy_volume(plain_grid({{2, 3, 2}}), 5)}) {
    const Dataset dataset = built_dataset(volume);
    MeshOptions options;
    options.query.max_error = 0;
    SimplexMesh mesh;
    Progress progress;
    ASSERT_TRUE(dataset.extract_mesh(options, mesh, progress));
    for (const std::optional<Box3d>& box : boxes_in(volume.info.grid)) {
      const Summed truth = sum_of(mesh, box);
      const IntegralReport report = integral_of(dataset, {.box = box});
      expect_sums(report, truth);
      n_empty += report.is_empty ? 1 : 0;
      if (report.is_empty) continue;
      EXPECT_EQ(report.probe.achieved_error, 0);
      // Where it cuts cells, by what rounding is of these.
      const double cell = std::abs(determinant(volume.info.grid.index_to_world_matrix()));
      EXPECT_LT(report.integral.high - report.integral.low,
                1e-9 * (truth.volume + 100 * cell) *
                    std::max(std::abs(truth.lowest), std::abs(truth.highest)));
      if (!box) EXPECT_EQ(report.n_cells, mesh.tetrahedra.size());
    }
  }
  EXPECT_GT(n_empty, 0U);
}

/// The integral of a linear function is its value in the middle times the volume.
TEST(volume_integral, of_linear_fields_is_exact_in_any_box) {
  const RegularGrid grid = awkward_grid({{40, 150, 12}});
  const auto linear = [](const Vec3d& p) { return 3 * p[0] - 2 * p[1] + 0.5 * p[2] + 7; };
  const Volume volume = oracles::volume_of<double>(grid, [&](const Index3& p) {
    return linear(grid.to_world({{double(p[0]), double(p[1]), double(p[2])}}));
  });
  const Dataset dataset = built_dataset(volume);
  const Vec3d middle = grid.to_world({{19.5, 74.5, 5.5}});
  for (const Vec3d& half : {Vec3d{{3, 2, 5}}, Vec3d{{0.3, 0.4, 0.1}}, Vec3d{{4.9, 6.1, 7.3}}}) {
    const IntegralReport report =
        integral_of(dataset, {.box = Box3d{middle - half, middle + half}});
    const double size = 8 * half[0] * half[1] * half[2];
    expect_holds(report.volume, size, 1e-12 * size);
    expect_holds(report.mean, linear(middle), 1e-10);
    EXPECT_NEAR(report.mean.value, linear(middle), 1e-9);
    const double reach = 3 * half[0] + 2 * half[1] + 0.5 * half[2];
    expect_holds(report.maximum, linear(middle) + reach, 1e-9);
    expect_holds(report.minimum, linear(middle) - reach, 1e-9);
  }
}

TEST(volume_integral, of_all_types_is_the_mean_of_their_samples) {
  const RegularGrid grid = plain_grid({{131, 5, 4}});
  const auto value = [](const Index3& p) { return 40.0 + (p[0] * 7 + p[1] * 13 + p[2] * 29) % 80; };
  const auto expect_mean = [&](const Volume& volume) {
    // By its weights: a quarter for ends of diagonals, a twelfth for other corners of a cell.
    double sum = 0;
    for (std::int32_t z = 0; z < 3; ++z)
      for (std::int32_t y = 0; y < 4; ++y)
        for (std::int32_t x = 0; x < 130; ++x)
          for (int k = 0; k < 8; ++k) {
            const Index3 p{{x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)}};
            const int n_odd = (p[0] & 1) + (p[1] & 1) + (p[2] & 1);
            sum += value(p) / (n_odd % 3 == 0 ? 4 : 12);
          }
    const IntegralReport report = integral_of(built_dataset(volume), {});
    expect_holds(report.integral, sum, 1e-9);
    EXPECT_EQ(report.volume.value, 130 * 4 * 3);
    EXPECT_EQ(report.minimum.value, report.minimum.low);
  };
  expect_mean(oracles::volume_of<std::uint8_t>(grid, value));
  expect_mean(oracles::volume_of<std::int16_t>(grid, value));
  expect_mean(oracles::volume_of<std::uint32_t>(grid, value));
  expect_mean(oracles::volume_of<float>(grid, value));
  expect_mean(oracles::volume_of<double>(grid, value));
}

TEST(volume_integral, at_a_tolerance_has_bounds_of_the_exact_one) {
  const RegularGrid grid = awkward_grid({{120, 110, 90}});
  const Volume volume = oracles::volume_of<float>(grid, [](const Index3& p) {
    return 200 * std::exp(-1e-3 * ((p[0] - 70) * (p[0] - 70) + (p[1] - 60) * (p[1] - 60) +
                                   (p[2] - 20) * (p[2] - 20)));
  });
  const Dataset dataset = built_dataset(volume);
  std::size_t n_coarse = 0;
  for (const std::optional<Box3d>& box : boxes_in(grid)) {
    const IntegralReport exact = integral_of(dataset, {.box = box});
    for (const double tolerance : {60.0, 20.0, 1e-3}) {
      const IntegralReport report = integral_of(dataset, {.box = box, .max_error = tolerance});
      EXPECT_EQ(report.probe.max_error, tolerance);
      EXPECT_LE(report.probe.achieved_error, tolerance);
      ASSERT_EQ(report.is_empty, exact.is_empty);
      if (report.is_empty) continue;
      n_coarse += report.probe.achieved_error > 0 ? 1 : 0;
      const double rounding = 1e-9 * exact.volume.value;
      expect_holds(report.volume, exact.volume.value, rounding);
      expect_holds(report.integral, exact.integral.value, 200 * rounding);
      expect_holds(report.mean, exact.mean.value, 1e-9);
      expect_holds(report.minimum, exact.minimum.value, 1e-9);
      expect_holds(report.maximum, exact.maximum.value, 1e-9);
      EXPECT_LE(report.mean.high - report.mean.low, 2 * tolerance + 1e-6);
    }
  }
  EXPECT_GT(n_coarse, 3U);
}

/// Of which a coarse cut could leave cells out.
TEST(volume_integral, at_a_tolerance_misses_nothing_round_holes) {
  const RegularGrid grid = plain_grid({{65, 61, 57}});
  const Dataset dataset = built_dataset(oracles::volume_of<float>(grid, [](const Index3& p) {
    return std::hypot(p[0] - 30.5, p[1] - 28.0, p[2] - 26.2) < 8 ? std::nan("") : 0.02 * p[0] + 1;
  }));
  for (const std::optional<Box3d>& box :
       {std::optional<Box3d>{}, std::optional<Box3d>{Box3d{{{20, 20, 20}}, {{45, 40, 41}}}},
        std::optional<Box3d>{Box3d{{{20, 5, 30}}, {{21, 5.5, 31}}}}}) {
    const IntegralReport exact = integral_of(dataset, {.box = box});
    ASSERT_FALSE(exact.is_empty);
    for (const double tolerance : {0.1, 0.5, 5.0}) {
      const IntegralReport report = integral_of(dataset, {.box = box, .max_error = tolerance});
      ASSERT_FALSE(report.is_empty);
      expect_holds(report.volume, exact.volume.value, 1e-9 * exact.volume.value);
      expect_holds(report.integral, exact.integral.value, 1e-9 * exact.volume.value);
      expect_holds(report.minimum, exact.minimum.value, 1e-9);
    }
  }
}

TEST(volume_integral, is_the_same_for_any_threads_and_from_files) {
  const store::TestPath path("probed.lode");
  const Volume volume = noisy_volume(awkward_grid({{70, 140, 66}}), 11);
  const Dataset held = built_dataset(volume);
  const std::string file = test::stored(path, volume);
  const auto text_of = [](const IntegralReport& report) {
    return fmt::format("{} {} {} {} {} {} {}", report.volume.low, report.integral.low,
                       report.integral.value, report.integral.high, report.minimum.low,
                       report.maximum.high, report.n_cells);
  };
  for (const std::optional<Box3d>& box : boxes_in(volume.info.grid)) {
    const std::string expected = text_of(integral_of(held, {.box = box, .threads = {1}}));
    EXPECT_EQ(expected, text_of(integral_of(held, {.box = box, .threads = {3}})));
    const Dataset opened = Dataset::open(file, {2}).value();
    EXPECT_EQ(expected, text_of(integral_of(opened, {.box = box, .threads = {2}})));
  }
}

TEST(volume_probe, reads_of_a_file_what_is_near) {
  const store::TestPath path("probed.lode");
  const Volume volume = noisy_volume(plain_grid({{140, 131, 129}}), 12);
  const std::string file = test::stored(path, volume);
  const Dataset held = built_dataset(volume);
  const std::vector<Vec3d> points{{{100.3, 17.2, 99.9}}, {{101, 18, 98.5}}, {{139, 130, 128}}};
  Progress progress;
  const Dataset opened = Dataset::open(file, {2}).value();
  std::vector<ProbedPoint> found;
  ASSERT_TRUE(opened.probe(points, {}, found, progress));
  const std::uint64_t bytes = opened.reads().bytes;
  const std::vector<ProbedPoint> expected = probed(held, points, {});
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(found[i].is_exact);
    EXPECT_EQ(found[i].value.value, expected[i].value.value);
    EXPECT_EQ(found[i].value.low, expected[i].value.low);
  }
  EXPECT_LT(bytes, std::filesystem::file_size(file) / 2);
  // A limit that the pages of a point do not fit in is told, and bounds are still right.
  const Dataset limited = Dataset::open(file, {2}).value();
  const auto report = limited.probe(points, {.memory_limit = 200'000}, found, progress);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->memory_met);
  EXPECT_GT(report->achieved_error, 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    expect_holds(found[i].value, expected[i].value.value, kRounding);
}

TEST(volume_probe, refuses_what_it_cannot_answer) {
  Progress progress;
  std::vector<ProbedPoint> found;
  std::vector<ProbedLinePoint> line;
  const Dataset volume = built_dataset(noisy_volume(plain_grid({{5, 5, 5}}), 1));
  const std::vector<Vec3d> points{{{1, 1, 1}}};
  const std::vector<Vec3d> none{{{1, std::nan(""), 1}}};
  EXPECT_FALSE(volume.probe(none, {}, found, progress));
  EXPECT_FALSE(volume.probe(points, {.max_error = -1}, found, progress));
  EXPECT_FALSE(volume.probe(points, {.field = 1}, found, progress));
  EXPECT_FALSE(volume.probe(points, {.snap = -1}, found, progress));
  EXPECT_FALSE(volume.integrate({.regions = {1}}, progress));
  EXPECT_FALSE(volume.integrate({.max_error = std::nan("")}, progress));
  EXPECT_FALSE(volume.probe_line({points[0], points[0]}, {}, line, progress));
  const Dataset image = built_dataset(noisy_volume(plain_grid({{5, 5, 1}}), 1));
  const auto refused = image.probe(points, {}, found, progress);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("5 x 5 x 1"), std::string::npos);
  EXPECT_FALSE(image.integrate({}, progress));
}

}  // namespace
}  // namespace lode
