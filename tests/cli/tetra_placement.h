#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/tetra_surfaces.h"
#include "tests/oracles/trials.h"

namespace lode::test {

/// Noise in a file, for midpoints to be made of.
class cli_tetra_placement : public testing::Test {
 protected:
  static inline const int kPoints = oracles::trials(13, 9);
  /// Of cells, for which the base is too little and all are too many.
  static inline const int kBudget = oracles::trials(4000, 1200);
  /// A mesh's cells by what lies at their corners, sorted.
  using CellKey = std::array<std::tuple<double, double, double, double>, 4>;

  cli_tetra_placement() {
    Progress progress;
    EXPECT_TRUE(write_vtu(input_, noise(), {.value_name = "noise"}, progress));
  }

  [[nodiscard]] static Words midpoint(Words words) {
    words.insert(words.begin(), "extract");
    words.insert(words.end(), {"--placement", "midpoint"});
    return words;
  }
  [[nodiscard]] static nlohmann::json done(Words words) {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  [[nodiscard]] static TetraMesh read(const std::string& path) {
    auto cells = read_cell_mesh(path, {});
    EXPECT_TRUE(cells);
    auto made = to_tetrahedra(std::move(*cells), {.fields = std::vector<std::string>{"noise"}});
    EXPECT_TRUE(made);
    return std::move(made->mesh);
  }

  [[nodiscard]] static SimplexMesh noise() {
    return oracles::to_simplex_mesh(oracles::noise_mesh(kPoints, oracles::Cut::in_six, 5));
  }
  [[nodiscard]] static std::vector<CellKey> sorted_cells(const TetraMesh& mesh) {
    std::vector<CellKey> keys;
    for (const auto& t : mesh.tetrahedra) {
      CellKey& key = keys.emplace_back();
      for (std::size_t i = 0; i < 4; ++i) {
        const Vec3d& p = mesh.positions[t[i]];
        key[i] = {p[0], p[1], p[2], mesh.fields[0].values[t[i]]};
      }
      std::ranges::sort(key);
    }
    std::ranges::sort(keys);
    return keys;
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.vtu";
  std::string output_ = scratch_ / "out.vtu";
};

}  // namespace lode::test
