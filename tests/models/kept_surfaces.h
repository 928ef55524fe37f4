#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "lode/api/dataset_impl.h"
#include "lode/mappers/surface_topology.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"

namespace lode::test {

inline constexpr double kAny = 1e9;
inline constexpr std::optional<double> kNotKept{};

inline ComponentTypes pieces_of(const Surface& surface) {
  const TopologyReport report = check_topology(surface, {});
  EXPECT_TRUE(report.is_clean_manifold());
  return component_types(report);
}

inline Dataset built_in_memory(const Volume& volume) {
  Progress progress;
  return Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress).value();
}

inline Surface surface_of(const Dataset& dataset, double isovalue, std::optional<double> max_error,
                          std::optional<double> keep_topology,
                          std::optional<double> max_distance = {}, int threads = 2) {
  Progress progress;
  Surface surface;
  const auto report = dataset.extract({.isovalues = {isovalue},
                                       .max_error = max_error,
                                       .max_distance = max_distance,
                                       .keep_topology = keep_topology,
                                       .normals = Normals::off,
                                       .threads = {threads}},
                                      surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (report && keep_topology) EXPECT_TRUE(report->topology);
  return surface;
}

/// Noise through boxes of 3^3 samples, so that there are larger and smaller features.
inline Volume smoothed_noise(const Index3& dims, std::uint64_t seed, int n_rounds) {
  oracles::Random random(seed);
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 2, 1.25}};
  std::vector<double> values(static_cast<std::size_t>(grid.n_samples()));
  for (double& v : values) v = random.uniform(-1, 1);
  const auto at = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    const auto clamped = [&](std::int32_t p, std::size_t axis) {
      return static_cast<std::size_t>(std::clamp(p, 0, dims[axis] - 1));
    };
    return (clamped(z, 2) * static_cast<std::size_t>(dims[1]) + clamped(y, 1)) *
               static_cast<std::size_t>(dims[0]) +
           clamped(x, 0);
  };
  for (int round = 0; round < n_rounds; ++round) {
    std::vector<double> next(values.size());
    for (std::int32_t z = 0; z < dims[2]; ++z)
      for (std::int32_t y = 0; y < dims[1]; ++y)
        for (std::int32_t x = 0; x < dims[0]; ++x)
          for (std::int32_t i = 0; i < 27; ++i)
            next[at(x, y, z)] += values[at(x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1)] / 9;
    values = next;
  }
  return oracles::volume_of<float>(grid,
                                   [&](const Index3& p) { return values[at(p[0], p[1], p[2])]; });
}

}  // namespace lode::test
