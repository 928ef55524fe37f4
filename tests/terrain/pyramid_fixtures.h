#pragma once

// Pyramids kept by levels, of all kinds of terrain.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/models/terrain/delaunay_pyramid/pyramid.h"
#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/overlap.h"
#include "tests/terrain/insertions_fixtures.h"

namespace lode::delaunay_pyramid::test {

using insertions::LevelledHistory;

inline constexpr std::array kEncodings{Encoding::complete, Encoding::lists, Encoding::linked_lists};
inline constexpr EncodingLimit kLimit{};

/// With tolerances that the base keeps, that are one insertion apart or none, and that are not.
inline LevelledHistory history_of(const HeightGrid& grid) {
  return {insertions::test::history_of(grid, 2, insertions::Model::delaunay_pyramid),
          {100'000, 50'000, 400, 200, 90, 30, 29.999, 7.5, 2}};
}

inline std::vector<LevelledHistory> histories() {
  std::vector<LevelledHistory> all;
  for (const insertions::test::Case& c : insertions::test::cases())
    all.push_back(history_of(c.grid));
  all.push_back(insertions::test::make_point_model(insertions::Model::delaunay_pyramid));
  return all;
}

inline Pyramid pyramid_of(const LevelledHistory& levelled, Encoding encoding) {
  Progress progress;
  auto made = encode(levelled.history, levelled.levels, encoding, kLimit, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

/// Of a level, what meets a triangle's interior.
inline std::vector<std::uint32_t> meeting(const Pyramid& pyramid,
                                          const std::array<std::uint32_t, 3>& triangle,
                                          const PyramidLevel& others) {
  const auto placed = [&](const std::array<std::uint32_t, 3>& t) {
    return delaunay::LatticeCorners{pyramid.vertices[t[0]], pyramid.vertices[t[1]],
                                    pyramid.vertices[t[2]]};
  };
  std::vector<std::uint32_t> all;
  const delaunay::LatticeCorners own = placed(triangle);
  const insertions::LatticeBox box = insertions::box_of(own);
  for (std::uint32_t other = 0; other < others.triangles.size(); ++other) {
    const delaunay::LatticeCorners corners = placed(others.triangles[other]);
    if (box.meets(insertions::box_of(corners)) && insertions::do_interiors_meet(own, corners))
      all.push_back(other);
  }
  return all;
}

}  // namespace lode::delaunay_pyramid::test
