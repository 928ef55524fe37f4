#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "lode/api/files.h"
#include "tests/cli/program.h"

namespace lode::test {

/// Waves on a grid of n^3 points over [0, n - 1]^3, in six tetrahedra a cell.
inline SimplexMesh waves(std::uint32_t n) {
  SimplexMesh mesh;
  const auto id = [n](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (z * n + y) * n + x;
  };
  for (std::uint32_t z = 0; z < n; ++z)
    for (std::uint32_t y = 0; y < n; ++y)
      for (std::uint32_t x = 0; x < n; ++x) {
        const Vec3d p{{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}};
        mesh.positions.push_back(p);
        mesh.values.push_back(10 * std::sin(0.5 * p[0]) * std::cos(0.4 * p[1]) + p[2]);
        if (x + 1 == n || y + 1 == n || z + 1 == n) continue;
        const std::uint32_t a = id(x, y, z);
        const std::uint32_t b = id(x + 1, y + 1, z + 1);
        const std::array<std::uint32_t, 7> ring{
            id(x + 1, y, z), id(x + 1, y + 1, z), id(x, y + 1, z), id(x, y + 1, z + 1),
            id(x, y, z + 1), id(x + 1, y, z + 1), id(x + 1, y, z)};
        for (std::size_t i = 0; i < 6; ++i) mesh.tetrahedra.push_back({a, ring[i], ring[i + 1], b});
      }
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  return mesh;
}

class cli_tetra : public testing::Test {
 protected:
  cli_tetra() {
    Progress progress;
    EXPECT_TRUE(write_vtu(input_, waves(13), {.value_name = "wave"}, progress));
  }

  [[nodiscard]] Finished extract(std::vector<std::string> options) const {
    options.insert(options.begin(), {"extract", input_, output_, "--mesh"});
    return run_lode(options);
  }
  [[nodiscard]] nlohmann::json report(std::vector<std::string> options) const {
    options.emplace_back("--json");
    const Finished run = extract(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.vtu";
  std::string output_ = scratch_ / "out.vtu";
};

}  // namespace lode::test
