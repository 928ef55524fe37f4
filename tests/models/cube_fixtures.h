#pragma once

// Surfaces of full resolution in both styles, and what they are made of.

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/mappers/surface_topology.h"

namespace lode::test {

inline Dataset dataset_of(const Volume& volume) {
  Progress progress;
  return Dataset::build(*make_memory_source(volume), {.threads = {1}}, progress).value();
}

inline Surface styled(const Dataset& dataset, double isovalue, SurfaceStyle style,
                      Normals normals = Normals::off, int threads = 1) {
  Progress progress;
  Surface surface;
  EXPECT_TRUE(dataset.extract({.isovalues = {isovalue},
                               .max_error = 0.0,
                               .style = style,
                               .normals = normals,
                               .threads = {threads}},
                              surface, progress));
  return surface;
}

/// Euler numbers of the pieces, and whether they are closed.
inline std::vector<std::pair<std::int64_t, bool>> pieces_of(const TopologyReport& topology) {
  std::vector<std::pair<std::int64_t, bool>> pieces;
  for (const ComponentReport& c : topology.components)
    pieces.emplace_back(c.euler_number, c.n_boundary_edges == 0);
  std::ranges::sort(pieces);
  return pieces;
}

}  // namespace lode::test
