#pragma once

// Volumes, and the plain facts about meshes of them that tests look at: slow and independent.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "lode/api/mesh_extraction.h"
#include "lode/core/volume.h"
#include "lode/models/diamond/cell_field.h"

namespace lode::test {

inline RegularGrid plain_grid(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return grid;
}

/// Anisotropic, turned, mirrored and away from the origin.
inline RegularGrid awkward_grid(const Index3& dims) {
  RegularGrid grid = plain_grid(dims);
  grid.spacing = {{0.5, 1, 2.25}};
  grid.origin = {{-30, 7.25, 100}};
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  grid.direction = {{Vec3d{{-c, s, 0}}, Vec3d{{s, c, 0}}, Vec3d{{0, 0, 1}}}};
  return grid;
}

/// Smooth with noise on it, so that errors differ from place to place.
inline Volume noisy_volume(const RegularGrid& grid, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> samples;
  for (std::int32_t z = 0; z < grid.dims[2]; ++z)
    for (std::int32_t y = 0; y < grid.dims[1]; ++y)
      for (std::int32_t x = 0; x < grid.dims[0]; ++x)
        samples.push_back(static_cast<float>(50 + 30 * std::sin(0.4 * x) * std::cos(0.3 * y) + z) +
                          static_cast<float>(random() % 1000) / 100);
  return make_volume<float>(grid, samples);
}

/// The same with some samples missing.
inline Volume holed_volume(const RegularGrid& grid, std::uint32_t seed) {
  const Volume whole = noisy_volume(grid, seed);
  std::vector<float> samples(whole.as<float>().begin(), whole.as<float>().end());
  std::mt19937 random(seed + 1);
  for (float& sample : samples)
    if (random() % 60 == 0) sample = std::numeric_limits<float>::quiet_NaN();
  return make_volume<float>(grid, samples);
}

inline Dataset dataset_of(const Volume& volume) {
  Progress progress;
  const auto source = make_memory_source(volume);
  return Dataset::build(*source, {.threads = {2}}, progress).value();
}

inline double sample_at(const Volume& volume, const Index3& p) {
  const Index3& dims = volume.info.grid.dims;
  return static_cast<double>(
      volume.as<float>()[static_cast<std::size_t>((p[2] * dims[1] + p[1]) * dims[0] + p[0])]);
}

/// F at a world point; NaN in a removed cell.
inline double field_at(const Volume& volume, const Vec3d& world) {
  const diamond::VolumeSamples samples(volume);
  const Vec3d index = volume.info.grid.to_index(world);
  Index3 cell;
  for (std::size_t i = 0; i < 3; ++i)
    cell[i] = std::clamp(static_cast<std::int32_t>(std::floor(index[i])), 0,
                         std::max(0, volume.info.grid.dims[i] - 2));
  const diamond::CellField field(samples, cell, 0);
  return field.is_removed() ? std::numeric_limits<double>::quiet_NaN()
                            : field.value_at(field.to_local(index));
}

/// The samples that a mesh's vertices lie at.
inline std::vector<Index3> lattice_points(const SimplexMesh& mesh, const RegularGrid& grid) {
  std::vector<Index3> points;
  for (const Vec3d& p : mesh.positions) {
    const Vec3d index = grid.to_index(p);
    Index3& point = points.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      point[i] = static_cast<std::int32_t>(std::lround(index[i]));
      EXPECT_NEAR(index[i], point[i], 1e-9);
      EXPECT_TRUE(point[i] >= 0 && point[i] < grid.dims[i]);
    }
  }
  return points;
}

using Wide3 = Vec<std::int64_t, 3>;

inline Wide3 wide(const Index3& p) { return {{p[0], p[1], p[2]}}; }

/// Six times the volume, exact.
inline std::int64_t volume6(const std::array<Index3, 4>& t) {
  const Wide3 o = wide(t[0]);
  return dot(cross(wide(t[1]) - o, wide(t[2]) - o), wide(t[3]) - o);
}

inline std::array<Index3, 4> corners_of(const SimplexMesh& mesh, const std::vector<Index3>& points,
                                        std::size_t cell) {
  std::array<Index3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = points[mesh.tetrahedra[cell][i]];
  return corners;
}

inline bool is_on_border(const std::vector<Index3>& face, const Index3& dims) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto all_at = [&](std::int32_t x) {
      return std::all_of(face.begin(), face.end(), [&](const Index3& p) { return p[i] == x; });
    };
    if (all_at(0) || all_at(dims[i] - 1)) return true;
  }
  return false;
}

}  // namespace lode::test
