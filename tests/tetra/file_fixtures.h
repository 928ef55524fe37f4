#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/persist.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {

inline tetra_mt::Hierarchy hierarchy_of(const TetraMesh& mesh, std::uint64_t base_cells) {
  Progress progress;
  const auto collapses = tetra_mt::collapse_half_edges(
      mesh, {.base_cells = base_cells, .rules = {}, .threads = {2}}, progress);
  EXPECT_TRUE(collapses);
  auto hierarchy = tetra_mt::make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy);
  return std::move(*hierarchy);
}

/// Any.
inline tetra_mt::GradientsOf codes_of(const tetra_mt::Hierarchy& hierarchy) {
  return [n = hierarchy.positions.size()](std::size_t field) {
    std::vector<std::uint32_t> codes;
    for (std::uint32_t v = 0; v < n; ++v)
      codes.push_back((v + static_cast<std::uint32_t>(field)) * 2654435761U);
    return codes;
  };
}

inline TetraMesh noise() { return oracles::noise_mesh(17, oracles::Cut::in_five, 5); }

}  // namespace lode::test
