// The band of a field, against its samples one by one and against the check of level sets.

#include "lode/models/diamond/field_band.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "lode/models/diamond/build.h"
#include "lode/models/diamond/level_set_check.h"
#include "lode/models/diamond/model_samples.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::diamond {
namespace {

using oracles::Random;

struct Case {
  Volume volume;
  double isovalue = 0;
  double error = 0;
};

template <typename T>
Case noise_case(const Index3& dims, double low, double high, std::uint64_t seed) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1.25, 2}};
  grid.origin = {{-3, 100, 7}};
  Random random(seed);
  return {oracles::volume_of<T>(grid, [&](const Index3&) { return random.uniform(low, high); }),
          0.5 * (low + high), 0.2 * (high - low)};
}

Model<3> model_of(const Volume& volume) {
  Progress progress;
  const auto source = make_memory_source(volume);
  return build<3>(*source, {.threads = {2}}, progress).value();
}

class field_band_cases : public testing::TestWithParam<int> {
 protected:
  field_band_cases() : case_(of(GetParam())), model_(model_of(case_.volume)) {
    band_ = make_field_band(model_, case_.isovalue, case_.error, {2});
  }

  static Case of(int number) {
    switch (number) {
      case 0: return noise_case<std::uint8_t>({{9, 8, 7}}, 10, 200, 1);
      case 1: return noise_case<std::int16_t>({{70, 5, 6}}, -900, 900, 2);
      case 2: return noise_case<float>({{34, 33, 3}}, -1, 1, 3);
      case 3: return noise_case<double>({{66, 35, 2}}, 1e9, 1e9 + 5, 4);
      default: {
        Case holes = noise_case<float>({{40, 12, 34}}, -1, 1, 5);
        auto samples = oracles::typed_samples<float>(holes.volume);
        for (std::size_t i = 0; i < samples.size(); i += 97)
          samples[i] = std::numeric_limits<float>::quiet_NaN();
        return holes;
      }
    }
  }

  [[nodiscard]] Vec3d point(Random& random) const {
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = random.uniform(0, static_cast<double>(case_.volume.info.grid.dims[i] - 1));
    return p;
  }
  /// A point near another, or by chance far away, and by chance on the lattice.
  [[nodiscard]] Vec3d point_near(Random& random, const Vec3d& other) const {
    const double reach = random.below(5) == 0 ? 8 : 1;
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = std::clamp(other[i] + random.uniform(-reach, reach), 0.0,
                        static_cast<double>(case_.volume.info.grid.dims[i] - 1));
      if (random.below(4) == 0) p[i] = std::round(p[i]);
    }
    return p;
  }

  Case case_;
  Model<3> model_;
  std::unique_ptr<SurfaceBand> band_;
};

/// Barycentric coordinates of p, by Cramer's rule; the least of them.
double least_weight(const std::array<Vec3d, 4>& t, const Vec3d& p) {
  const auto volume = [](const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    return dot(cross(b - a, c - a), d - a);
  };
  const double whole = volume(t[0], t[1], t[2], t[3]);
  return std::min({volume(p, t[1], t[2], t[3]) / whole, volume(t[0], p, t[2], t[3]) / whole,
                   volume(t[0], t[1], p, t[3]) / whole, volume(t[0], t[1], t[2], p) / whole});
}

TEST_P(field_band_cases, misses_no_sample_outside_the_band_in_a_tetrahedron_and_invents_few) {
  const ModelSamples<3> samples(model_);
  const Index3& dims = case_.volume.info.grid.dims;
  Random random(7);
  int n_held = 0;
  int n_empty = 0;
  int n_invented = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::array<Vec3d, 4> t;
    t[0] = point(random);
    for (std::size_t k = 1; k < 4; ++k) t[k] = point_near(random, t[0]);
    if (std::abs(dot(cross(t[1] - t[0], t[2] - t[0]), t[3] - t[0])) < 1e-3) continue;
    bool holds = false;
    bool is_close = false;
    Index3 p;
    for (p[2] = 0; p[2] < dims[2]; ++p[2])
      for (p[1] = 0; p[1] < dims[1]; ++p[1])
        for (p[0] = 0; p[0] < dims[0]; ++p[0]) {
          if (!(std::abs(samples.sample(p) - case_.isovalue) > case_.error)) continue;
          const Vec3d at{
              {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}};
          const double weight = least_weight(t, at);
          holds = holds || weight >= 0;
          is_close = is_close || weight > -1e-2;
        }
    const bool found = band_->may_hold_fixed(t);
    if (holds) EXPECT_TRUE(found);
    n_held += holds ? 1 : 0;
    n_empty += is_close ? 0 : 1;
    n_invented += !is_close && found ? 1 : 0;
  }
  EXPECT_GT(n_held, 100);
  EXPECT_GT(n_empty, 100);
  EXPECT_EQ(n_invented, 0);
}

TEST_P(field_band_cases, finds_samples_in_flat_tetrahedra) {
  const ModelSamples<3> samples(model_);
  Random random(8);
  int n_held = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    // A sample that is a mean of three corners of a triangle, the fourth in their plane.
    Index3 at;
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i) {
      at[i] = static_cast<std::int32_t>(
          random.below(static_cast<std::uint64_t>(case_.volume.info.grid.dims[i])));
      p[i] = static_cast<double>(at[i]);
    }
    if (!(std::abs(samples.sample(at) - case_.isovalue) > case_.error)) continue;
    const Vec3d u{{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)}};
    const Vec3d v{{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)}};
    const double s = random.uniform(-1, 1);
    EXPECT_TRUE(band_->may_hold_fixed({p + u, p + v, p - u - v, p + u * s + v * (0.5 * s)}));
    EXPECT_TRUE(band_->may_hold_fixed({p + u, p - u, p + u * 0.5, p + u * s}));
    EXPECT_TRUE(band_->may_hold_fixed({p, p, p, p}));
    ++n_held;
  }
  EXPECT_GT(n_held, 200);
}

TEST_P(field_band_cases, measures_triangles_as_the_check_does) {
  const ModelSamples<3> samples(model_);
  const RegularGrid& grid = case_.volume.info.grid;
  Random random(9);
  Progress progress;
  int n_beyond = 0;
  int n_within = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    Surface surface;
    const Vec3d first = point(random);
    std::array<Vec3d, 3> own;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d world = grid.to_world(k == 0 ? first : point_near(random, first));
      Vec3f p;
      for (std::size_t i = 0; i < 3; ++i) p[i] = static_cast<float>(world[i]);
      surface.positions.push_back(p);
      own[k] = band_->own_coordinates(widened(p));
    }
    surface.triangles.push_back({0, 1, 2});
    const auto report = check_level_set(
        samples, surface, {.isovalues = {case_.isovalue}, .tolerance = case_.error}, progress);
    const double found = band_->largest_deviation(own);
    if (!std::isfinite(found)) {
      EXPECT_FALSE(report->holds() && report->max_deviation < case_.error);
    } else if (report->max_deviation > case_.error) {
      EXPECT_NEAR(found, report->max_deviation, 1e-4 * case_.error);
      ++n_beyond;
    } else {
      EXPECT_LE(found, case_.error * (1 + 1e-4));
      ++n_within;
    }
    // Points that seem to be within the band are some of all.
    const std::array<std::array<Vec3d, 2>, 1> fan{{{own[1], own[2]}}};
    if (found <= 0.5 * case_.error) EXPECT_TRUE(band_->seems_within(own[0], fan));
  }
  EXPECT_GT(n_beyond, 100);
  EXPECT_GT(n_within, 10);
}

TEST_P(field_band_cases, knows_the_planes_of_the_border) {
  const RegularGrid& grid = case_.volume.info.grid;
  const auto planes = [&](const Vec3d& index) {
    return band_->border_planes(band_->own_coordinates(grid.to_world(index)));
  };
  const Vec3d end{{static_cast<double>(grid.dims[0] - 1), static_cast<double>(grid.dims[1] - 1),
                   static_cast<double>(grid.dims[2] - 1)}};
  EXPECT_EQ(planes({{0, 0, 0}}), 1U | 4U | 16U);
  EXPECT_EQ(planes(end), 2U | 8U | 32U);
  EXPECT_EQ(planes({{0.5, end[1], 0.25}}), 8U);
  EXPECT_EQ(planes({{0.5, 0.5, 0.5}}), 0U);
}

/// A box of the volume's samples, whose lattice begins at `origin`.
Volume box_of(const Volume& volume, const Index3& origin, const Index3& dims) {
  RegularGrid grid = volume.info.grid;  // its origin says nothing of the box
  grid.dims = dims;
  const VolumeSamples samples(volume);
  return visit_scalar_type(volume.info.type, [&]<typename T>() {
    return oracles::volume_of<T>(grid, [&](const Index3& p) { return samples.sample(p + origin); });
  });
}

TEST_P(field_band_cases, of_a_part_is_that_of_the_whole_where_it_is_known) {
  const Index3& dims = case_.volume.info.grid.dims;
  const Index3 origin{{dims[0] / 6 * 2, 0, dims[2] > 4 ? 2 : 0}};
  const Index3 part_dims{{dims[0] - origin[0], dims[1] - 1, dims[2] - origin[2]}};
  const Model<3> model = model_of(box_of(case_.volume, origin, part_dims));
  FieldPart part{.model = model,
                 .grid = case_.volume.info.grid,
                 .origin = {{origin[0], origin[1], origin[2]}},
                 .is_known = {}};
  const Index<3> blocks = FieldPart::block_dims({{part_dims[0], part_dims[1], part_dims[2]}});
  Random random(12);
  for (std::size_t i = 0; i < n_points<3>(blocks); ++i)
    part.is_known.push_back(i == 0 || random.below(4) == 0 ? 0 : 1);
  const auto is_known = part.is_known;
  const auto band = make_field_band(std::move(part), case_.isovalue, case_.error, {2});
  const Vec3d shift{{static_cast<double>(origin[0]), static_cast<double>(origin[1]),
                     static_cast<double>(origin[2])}};
  // Whether all cells that a box of points meets are known.
  const auto is_all_known = [&](std::span<const Vec3d> points) {
    Index<3> first;
    Index<3> last;
    for (std::size_t i = 0; i < 3; ++i) {
      double low = points[0][i];
      double high = low;
      for (const Vec3d& p : points) {
        low = std::min(low, p[i]);
        high = std::max(high, p[i]);
      }
      first[i] = std::max(0, static_cast<std::int32_t>(std::ceil(low)) - 1) / 4;
      last[i] = std::min(static_cast<std::int32_t>(high), part_dims[i] - 2) / 4;
    }
    Index<3> b;
    for (b[2] = first[2]; b[2] <= last[2]; ++b[2])
      for (b[1] = first[1]; b[1] <= last[1]; ++b[1])
        for (b[0] = first[0]; b[0] <= last[0]; ++b[0])
          if (is_known[linear_index<3>(blocks, b)] == 0) return false;
    return true;
  };
  int n_known = 0;
  int n_unknown = 0;
  for (int trial = 0; trial < 6000; ++trial) {
    std::array<Vec3d, 4> t;  // in the part
    for (std::size_t i = 0; i < 3; ++i) t[0][i] = random.uniform(0, part_dims[i] - 1);
    for (std::size_t k = 1; k < 4; ++k) {
      t[k] = point_near(random, t[0]);
      for (std::size_t i = 0; i < 3; ++i)
        t[k][i] = std::clamp(t[k][i], 0.0, static_cast<double>(part_dims[i] - 1));
    }
    std::array<Vec3d, 4> whole = t;
    for (Vec3d& p : whole) p = p + shift;
    const std::array<Vec3d, 3> triangle{t[0], t[1], t[2]};
    const double deviation = band->largest_deviation(triangle);
    const double expected = band_->largest_deviation({whole[0], whole[1], whole[2]});
    if (is_all_known(t)) {
      EXPECT_EQ(band->may_hold_fixed(t), band_->may_hold_fixed(whole));
      if (std::isfinite(expected))
        EXPECT_NEAR(deviation, expected, 1e-9 * case_.error);
      else
        EXPECT_FALSE(std::isfinite(deviation));
      ++n_known;
    } else {
      if (band_->may_hold_fixed(whole)) EXPECT_TRUE(band->may_hold_fixed(t));
      EXPECT_GE(deviation, expected * (1 - 1e-9));
      ++n_unknown;
    }
    EXPECT_EQ(
        band->border_planes(band->own_coordinates(case_.volume.info.grid.to_world(whole[0]))),
        band_->border_planes(band_->own_coordinates(case_.volume.info.grid.to_world(whole[0]))));
  }
  EXPECT_GT(n_known, 200);
  EXPECT_GT(n_unknown, 200);
}

INSTANTIATE_TEST_SUITE_P(types, field_band_cases, testing::Range(0, 5));

}  // namespace
}  // namespace lode::diamond
