#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {

/// Noise in [0, 1]^3, in blocks of cells that are of random regions, or each of its own at random.
inline TetraMesh random_regions(int n, std::uint32_t n_regions, int block, std::uint64_t seed) {
  TetraMesh mesh = oracles::noise_mesh(n + 1, oracles::Cut::in_six, seed);
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    std::uint64_t at = seed;
    for (const double x : centre.v)
      at = at * 1000 + static_cast<std::uint64_t>(static_cast<int>(x * n) / block);
    mesh.regions.push_back(static_cast<std::uint32_t>(oracles::Random(at).below(n_regions)));
  }
  for (std::uint32_t id = 0; id < n_regions; ++id)
    mesh.region_ids.push_back(7 * std::int64_t{id} - 3);
  return mesh;
}

inline TetraMesh scattered_regions(int n, double share) {
  TetraMesh mesh = oracles::noise_mesh(n + 1, oracles::Cut::in_five, 3);
  oracles::Random random(1);
  mesh.region_ids = {0, 1, 2, 3};
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    mesh.regions.push_back(
        random.uniform() < share ? 1 + static_cast<std::uint32_t>(random.below(3)) : 0);
  return mesh;
}

inline std::vector<TetraMesh> meshes_of_regions() {
  return {random_regions(12, 2, 6, 1), random_regions(12, 5, 4, 2), random_regions(12, 200, 3, 3),
          scattered_regions(7, 0.02), scattered_regions(7, 0.5)};
}

}  // namespace lode::test
