// Surfaces closed at the border, against the exact volume of {F >= c}.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "lode/api/creased_caps.h"
#include "lode/api/dataset.h"
#include "lode/mappers/surface_topology.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

struct Case {
  Dataset dataset;
  Volume volume;
};

Case case_of(const RegularGrid& grid, const std::function<float(const Index3&)>& field) {
  Volume volume = oracles::volume_of<float>(grid, field);
  Progress progress;
  auto dataset = Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress);
  EXPECT_TRUE(dataset);
  return {std::move(dataset).value(), std::move(volume)};
}

Case random_case(const RegularGrid& grid, std::uint64_t seed) {
  oracles::Random random(seed);
  return case_of(grid, [&](const Index3&) { return static_cast<float>(random.uniform(-1, 1)); });
}

ExtractOptions closed_at(double isovalue, double max_error) {
  return {
      .isovalues = {isovalue}, .max_error = max_error, .border = Border::closed, .threads = {2}};
}

Surface extract(const Case& c, const ExtractOptions& options) {
  Surface surface;
  Progress progress;
  const auto report = c.dataset.extract(options, surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  const auto verified = c.dataset.verify_surface(surface, options, progress);
  EXPECT_TRUE(verified) << (verified ? "" : verified.error().message);
  if (verified)
    for (const auto& check : verified->checks)
      EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  return surface;
}

void expect_watertight(const Surface& surface) {
  const TopologyReport topology = check_topology(surface, {});
  EXPECT_TRUE(topology.is_clean_manifold());
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(surface.normals.size(), surface.positions.size());
  EXPECT_TRUE(surface.isovalues.empty());
}

/// What the surface encloses: positive when its triangles face outward.
double enclosed_volume(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    std::array<Vec3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) p[i][k] = surface.positions[t[i]][k];
    sum += dot(p[0], cross(p[1], p[2])) / 6;
  }
  return sum;
}

/// The share of a tetrahedron in which the linear interpolant of four values is >= 0.
double inside_share(std::array<double, 4> f) {
  std::sort(f.begin(), f.end());
  if (f[0] >= 0) return 1;
  if (f[3] < 0) return 0;
  if (f[2] < 0) return std::pow(f[3], 3) / ((f[3] - f[0]) * (f[3] - f[1]) * (f[3] - f[2]));
  if (f[1] >= 0) return 1 + std::pow(f[0], 3) / ((f[1] - f[0]) * (f[2] - f[0]) * (f[3] - f[0]));
  // Two and two: one minus the two tetrahedra's difference, by the divided difference of t^3_+.
  const double a = std::pow(f[3], 3) / ((f[3] - f[0]) * (f[3] - f[1]) * (f[3] - f[2]));
  const double b = std::pow(f[2], 3) / ((f[2] - f[0]) * (f[2] - f[1]) * (f[3] - f[2]));
  return a - b;
}

/// The exact volume of {F >= c}, in cells: six tetrahedra round each cell's diagonal from its
/// all-even to its all-odd corner.
double true_volume(const Volume& volume, double isovalue) {
  const Index3& dims = volume.info.grid.dims;
  const auto samples = volume.as<float>();
  const auto value = [&](const Index3& p) {
    return samples[static_cast<std::size_t>(p[0] + dims[0] * (p[1] + dims[1] * p[2]))] - isovalue;
  };
  double sum = 0;
  Index3 cell;
  for (cell[2] = 0; cell[2] < dims[2] - 1; ++cell[2])
    for (cell[1] = 0; cell[1] < dims[1] - 1; ++cell[1])
      for (cell[0] = 0; cell[0] < dims[0] - 1; ++cell[0]) {
        std::array<std::size_t, 3> order{0, 1, 2};
        do {
          Index3 p;
          Index3 step;
          for (std::size_t i = 0; i < 3; ++i) {
            p[i] = cell[i] + cell[i] % 2;
            step[i] = cell[i] % 2 == 0 ? 1 : -1;
          }
          std::array<double, 4> f{value(p)};
          for (std::size_t n = 0; n < 3; ++n) {
            p[order[n]] += step[order[n]];
            f[n + 1] = value(p);
          }
          sum += inside_share(f) / 6;
        } while (std::next_permutation(order.begin(), order.end()));
      }
  return sum;
}

RegularGrid grid_with(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return grid;
}

TEST(close_border, encloses_exactly_the_values_from_the_isovalue_up) {
  for (const Index3& dims : {Index3{{2, 2, 2}}, Index3{{3, 3, 3}}, Index3{{2, 9, 5}},
                             Index3{{9, 8, 7}}, Index3{{5, 17, 34}}})
    for (int seed = 0; seed < oracles::trials(20, 6); ++seed) {
      const Case c = random_case(grid_with(dims), static_cast<std::uint64_t>(seed));
      for (const double isovalue : {-0.5, 0.0, 0.7}) {
        const Surface surface = extract(c, closed_at(isovalue, 0));
        if (surface.is_empty()) continue;
        expect_watertight(surface);
        EXPECT_NEAR(enclosed_volume(surface), true_volume(c.volume, isovalue),
                    1e-3 * static_cast<double>(c.volume.info.grid.n_samples()))
            << dims[0] << " " << dims[1] << " " << dims[2] << " seed " << seed;
      }
    }
}

TEST(close_border, holds_at_any_tolerance_and_in_any_frame) {
  for (std::uint64_t seed = 0; seed < oracles::trials(30U, 9U); ++seed) {
    RegularGrid grid = grid_with({{11, 7, 20}});
    if (seed % 3 == 1) grid.direction = {{Vec3d{{0, -1, 0}}, Vec3d{{-1, 0, 0}}, Vec3d{{0, 0, -1}}}};
    const double c = std::cos(0.3);
    const double s = std::sin(0.3);
    if (seed % 3 == 2) grid.direction = {{Vec3d{{c, s, 0}}, Vec3d{{s, -c, 0}}, Vec3d{{0, 0, 1}}}};
    grid.spacing = {{0.5, 1, 0.3}};
    grid.origin = {{-7, 100, 3.3}};
    const Case random = random_case(grid, seed);
    for (const double tolerance : {0.0, 0.4, 1.0, 1.6, 3.0}) {
      const Surface surface = extract(random, closed_at(0.1, tolerance));
      if (surface.is_empty()) continue;
      expect_watertight(surface);
      EXPECT_GT(enclosed_volume(surface), 0);
    }
  }
}

/// Whole numbers, some equal to the isovalue, on ramps that large simplices follow: the surface
/// passes through samples, and halfway between them, also where simplices would reach across.
TEST(close_border, holds_where_whole_numbers_meet_the_border) {
  for (std::uint64_t seed = 0; seed < oracles::trials(150U, 40U); ++seed) {
    oracles::Random random(seed);
    Index3 dims;
    Vec3d slope;
    for (std::size_t i = 0; i < 3; ++i) {
      dims[i] = static_cast<std::int32_t>(random.uniform(6, 24));
      slope[i] = random.uniform(-1, 1);
    }
    const Case c = case_of(grid_with(dims), [&](const Index3& p) {
      const double ramp = slope[0] * p[0] + slope[1] * p[1] + slope[2] * p[2];
      return static_cast<float>(std::floor(ramp + random.uniform(0, 2)));
    });
    const double isovalue = std::floor(dot(slope, {{dims[0] / 2.0, dims[1] / 2.0, dims[2] / 2.0}}));
    for (const double tolerance : {1.0, 2.0}) {
      const Surface closed = extract(c, closed_at(isovalue, tolerance));
      if (!closed.is_empty()) expect_watertight(closed);
      ExtractOptions open = closed_at(isovalue, tolerance);
      open.border = Border::open;
      extract(c, open);
    }
  }
}

/// A rotation from a random unit quaternion.
Mat3 random_rotation(oracles::Random& random) {
  std::array<double, 4> q;
  double length = 0;
  for (double& x : q) {
    x = random.uniform(-1, 1);
    length += x * x;
  }
  for (double& x : q) x /= std::sqrt(length);
  const auto [w, x, y, z] = q;
  return {{Vec3d{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)}},
           Vec3d{{2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)}},
           Vec3d{{2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}}};
}

/// In oblique frames rounding takes vertices out of the border planes and off straight lines, and
/// round samples equal to the isovalue they are close together.
TEST(close_border, holds_in_oblique_frames_where_samples_equal_the_isovalue) {
  for (std::uint64_t seed = 0; seed < oracles::trials(100U, 24U); ++seed) {
    oracles::Random random(seed);
    RegularGrid grid = grid_with({{13, 11, 9}});
    grid.direction = random_rotation(random);
    for (double& spacing : grid.spacing.v) spacing = random.uniform(0.3, 2);
    grid.origin = {{0, 10, seed % 2 == 0 ? 0.0 : 100.0}};
    const Case c = case_of(
        grid, [&](const Index3&) { return static_cast<float>(random.below(3 + seed % 4)); });
    for (const double tolerance : {0.0, 0.5}) {
      const Surface surface = extract(c, closed_at(1, tolerance));
      if (!surface.is_empty()) expect_watertight(surface);
    }
  }
}

TEST(close_border, adds_the_whole_box_round_a_bubble_of_low_values) {
  const Case c = case_of(grid_with({{20, 18, 17}}), [](const Index3& p) {
    return static_cast<float>(std::hypot(p[0] - 9, p[1] - 8, p[2] - 8));
  });
  const Surface surface = extract(c, closed_at(4.1, 0.5));
  expect_watertight(surface);
  EXPECT_EQ(check_topology(surface, {}).components.size(), 2U);
  EXPECT_NEAR(enclosed_volume(surface), 19 * 17 * 16 - 4.0 / 3 * 3.14159 * std::pow(4.1, 3), 60);
}

TEST(close_border, adds_nothing_to_a_bubble_of_high_values_and_nothing_to_nothing) {
  const Case c = case_of(grid_with({{20, 18, 17}}), [](const Index3& p) {
    return -static_cast<float>(std::hypot(p[0] - 9, p[1] - 8, p[2] - 8));
  });
  ExtractOptions options = closed_at(-4.1, 0);
  const Surface closed = extract(c, options);
  options.border = Border::open;
  EXPECT_EQ(extract(c, options).triangles, closed.triangles);
  EXPECT_TRUE(extract(c, closed_at(1000, 0)).is_empty());
}

/// Where all values are from the isovalue up, what encloses them is the border alone, also where
/// the tolerance has taken a bubble away.
TEST(close_border, is_the_border_itself_where_nothing_is_below) {
  const Case bubble = case_of(grid_with({{20, 18, 17}}), [](const Index3& p) {
    return p == Index3{{9, 8, 8}} ? 50.0F : 200.0F;
  });
  for (const auto& [isovalue, tolerance] :
       {std::pair{100.0, 200.0}, {50.0, 0.0}, {-1000.0, 0.0}, {-1000.0, 5.0}}) {
    const Surface box = extract(bubble, closed_at(isovalue, tolerance));
    EXPECT_EQ(box.triangles.size(), 12U);
    expect_watertight(box);
    EXPECT_NEAR(enclosed_volume(box), 19 * 17 * 16, 1e-6);
  }
  EXPECT_GT(extract(bubble, closed_at(100, 0)).triangles.size(), 12U);
  RegularGrid turned = grid_with({{5, 4, 3}});
  turned.direction = {{Vec3d{{0, -1, 0}}, Vec3d{{-1, 0, 0}}, Vec3d{{0, 0, -1}}}};
  turned.origin = {{1e7, -3, 5}};
  const Surface box = extract(case_of(turned, [](const Index3&) { return 7.0F; }), closed_at(5, 0));
  expect_watertight(box);
  EXPECT_NEAR(enclosed_volume(box), 4 * 3 * 2, 1e-6);
  const Case image = case_of(grid_with({{9, 12, 1}}), [](const Index3&) { return 7.0F; });
  EXPECT_EQ(extract(image, closed_at(5, 0)).lines.size(), 4U);
  EXPECT_TRUE(extract(image, closed_at(8, 0)).is_empty());
}

bool lies_in_border(const RegularGrid& grid, const Surface& surface,
                    const std::array<std::uint32_t, 3>& triangle) {
  const Box3d bounds = grid.world_bounds();
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double plane : {bounds.lower[axis], bounds.upper[axis]})
      if (std::ranges::all_of(triangle, [&](std::uint32_t v) {
            return static_cast<double>(surface.positions[v][axis]) == plane;
          }))
        return true;
  return false;
}

/// In pictures: a slope in a box, whose caps have their planes' normals and the slope its own.
TEST(close_border, has_creases_round_its_caps_where_they_are_wanted) {
  RegularGrid grid;
  grid.dims = {{9, 8, 7}};
  grid.spacing = {{0.5, 1, 2}};
  const Case c = case_of(
      grid, [](const Index3& p) { return static_cast<float>(p[0] - 0.3 * p[1] + 0.2 * p[2]); });
  const Surface closed = extract(c, closed_at(3.1, 0));
  Surface creased = closed;
  crease_caps(grid, {2}, creased);
  ASSERT_EQ(creased.triangles.size(), closed.triangles.size());
  EXPECT_GT(creased.positions.size(), closed.positions.size());
  EXPECT_EQ(creased.normals.size(), creased.positions.size());
  EXPECT_TRUE(creased.isovalues.empty());
  std::size_t n_caps = 0;
  for (std::size_t i = 0; i < closed.triangles.size(); ++i) {
    const auto& t = creased.triangles[i];
    const Vec3f a = creased.positions[t[0]];
    const Vec3f area = cross(creased.positions[t[1]] - a, creased.positions[t[2]] - a);
    const bool is_cap = lies_in_border(grid, creased, t);
    n_caps += is_cap ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(creased.positions[t[k]], closed.positions[closed.triangles[i][k]]);
      if (!is_cap) EXPECT_EQ(t[k], closed.triangles[i][k]);
      // Slivers of the slope face as their corners are rounded.
      if (is_cap || length(area) > 1e-3F)
        EXPECT_GT(dot(creased.normals[t[k]], normalized(area)), 0.999F);
    }
  }
  EXPECT_GT(n_caps, 50U);
}

TEST(close_border, closes_contour_lines_along_the_image_border) {
  for (const Index3& dims : {Index3{{9, 12, 1}}, Index3{{1, 20, 7}}, Index3{{33, 1, 18}}})
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const Case c = random_case(grid_with(dims), seed);
      for (const double tolerance : {0.0, 0.8}) {
        const Surface lines = extract(c, closed_at(0.2, tolerance));
        const TopologyReport topology = check_topology(lines, {});
        EXPECT_TRUE(topology.is_closed());
        EXPECT_TRUE(topology.is_clean_manifold());
      }
    }
}

TEST(close_border, leaves_holes_open_and_says_so) {
  const auto field = [](const Index3& p) {
    if (p == Index3{{9, 8, 8}}) return std::nanf("");
    return static_cast<float>(p[0]);
  };
  const Case c = case_of(grid_with({{20, 18, 17}}), field);
  Surface surface;
  Progress progress;
  const auto report = c.dataset.extract(closed_at(9.3, 0), surface, progress);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_GT(report->open_edges, 0U);
  EXPECT_EQ(check_topology(surface, {}).n_boundary_edges, report->open_edges);
}

TEST(close_border, refuses_what_it_cannot_close) {
  const Case c = case_of(grid_with({{20, 18, 17}}), [](const Index3& p) {
    return p[2] == 0 && p[1] == 5 ? std::nanf("") : static_cast<float>(p[0]);
  });
  Surface surface;
  Progress progress;
  const auto holed = c.dataset.extract(closed_at(9.3, 0), surface, progress);
  ASSERT_FALSE(holed);
  EXPECT_NE(holed.error().message.find("holes"), std::string::npos) << holed.error().message;
  const Case first = case_of(grid_with({{5, 4, 6}}), [](const Index3& p) {
    return p == Index3{{0, 0, 0}} ? std::nanf("") : 7.0F;
  });
  EXPECT_FALSE(first.dataset.extract(closed_at(5, 0), surface, progress));
  // Nothing to close is nothing to refuse.
  EXPECT_TRUE(c.dataset.extract(closed_at(1000, 0), surface, progress));
  EXPECT_TRUE(surface.is_empty());
  ExtractOptions options = closed_at(9.3, 0);
  options.isovalues.push_back(4);
  EXPECT_FALSE(c.dataset.extract(options, surface, progress));
  options = closed_at(9.3, 0);
  options.clip = Box3d{{{1, 1, 1}}, {{5, 5, 5}}};
  EXPECT_FALSE(c.dataset.extract(options, surface, progress));
}

}  // namespace
}  // namespace lode
