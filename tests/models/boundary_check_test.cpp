#include "lode/models/diamond/boundary_check.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/models/finest_level_set.h"

namespace lode::diamond {
namespace {

using test::finest_level_set;
using test::random_volume;

BoundaryReport border_report(const Volume& volume, const Surface& surface,
                             const BoundaryOptions& options = {}) {
  Progress progress;
  const VolumeSamples samples(volume);
  auto report = check_boundary(samples, surface, options, progress);
  EXPECT_TRUE(report);
  return *report;
}

RegularGrid grid_of(std::int32_t x, std::int32_t y, std::int32_t z) {
  RegularGrid grid;
  grid.dims = {{x, y, z}};
  grid.spacing = {{0.7, 1.1, 0.9}};
  grid.origin = {{-3, 5, 0.1}};
  return grid;
}

TEST(boundary_check, accepts_the_border_of_the_lattice) {
  for (const RegularGrid& grid : {grid_of(6, 7, 8), grid_of(2, 9, 2), grid_of(9, 1, 8)}) {
    const Volume volume = random_volume(grid, 1);
    const auto report = border_report(volume, finest_level_set(volume, 0.0));
    EXPECT_TRUE(report.holds());
    EXPECT_GT(report.n_on_border, 0U);
    EXPECT_EQ(report.n_on_border, report.n_edges);
  }
}

TEST(boundary_check, accepts_faces_of_removed_cells) {
  std::mt19937 random(3);
  for (const RegularGrid& grid : {grid_of(12, 12, 12), grid_of(30, 30, 1)}) {
    Volume volume = random_volume(grid, 2);
    std::vector<float> samples(volume.as<float>().begin(), volume.as<float>().end());
    for (float& sample : samples)
      if (random() % 20 == 0) sample = std::numeric_limits<float>::quiet_NaN();
    volume = make_volume<float>(grid, samples);
    const auto report = border_report(volume, finest_level_set(volume, 0.0));
    EXPECT_TRUE(report.holds()) << report.n_stray << " of " << report.n_edges;
    EXPECT_GT(report.n_on_holes, 0U);
  }
}

TEST(boundary_check, treats_nodata_as_holes) {
  std::vector<float> samples(27, 1.0F);
  for (std::size_t i = 0; i < 27; i += 3) samples[i] = -1.0F;
  samples[26] = -99.0F;
  Volume volume = make_volume<float>(grid_of(3, 3, 3), samples);
  volume.info.nodata = -99.0;
  std::vector<float> with_nan = samples;
  with_nan[26] = std::numeric_limits<float>::quiet_NaN();
  const Volume reference = make_volume<float>(grid_of(3, 3, 3), with_nan);
  const auto report = border_report(volume, finest_level_set(reference, 0.0));
  EXPECT_TRUE(report.holds());
}

TEST(boundary_check, finds_a_missing_triangle) {
  const Volume volume = random_volume(grid_of(8, 8, 8), 4);
  Surface surface = finest_level_set(volume, 0.0);
  const auto n = surface.triangles.size();
  surface.triangles.erase(surface.triangles.begin() + static_cast<std::ptrdiff_t>(n / 2));
  const auto report = border_report(volume, surface);
  EXPECT_GE(report.n_stray, 1U);
  EXPECT_NE(report.first_stray[0], report.first_stray[1]);
}

TEST(boundary_check, accepts_planes_of_the_clip_box_if_there_is_one) {
  const Volume volume = random_volume(grid_of(9, 9, 9), 5);
  Surface surface;
  surface.positions = {Vec3f{{-1, 7, 2}}, Vec3f{{1, 7, 2}}, Vec3f{{-1, 7, 4}}};
  surface.triangles = {{0, 1, 2}};
  EXPECT_EQ(border_report(volume, surface).n_stray, 3U);
  const auto report =
      border_report(volume, surface, {.clip = Box3d{{{-1, 6, 2}}, {{2, 8, 5}}}, .threads = {}});
  EXPECT_EQ(report.n_on_clip, 2U);
  EXPECT_EQ(report.n_stray, 1U);
}

}  // namespace
}  // namespace lode::diamond
