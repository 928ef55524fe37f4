#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include "lode/models/tetra_mt/midpoint/forest.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {

inline EdgeCollapses collapsed(const TetraMesh& mesh, std::uint64_t base_cells, int threads = 2) {
  Progress progress;
  auto result = collapse_edges(mesh, {.base_cells = base_cells, .threads = {threads}}, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : EdgeCollapses{};
}

inline Hierarchy hierarchy_of(const TetraMesh& mesh, const EdgeCollapses& collapses) {
  auto result = make_hierarchy(mesh, collapses, {2});
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : Hierarchy{};
}

/// All vertices that there ever are, by label; without cells. `field`: whose values they have.
inline TetraMesh all_vertices(const Hierarchy& hierarchy, std::size_t field = 0) {
  TetraMesh mesh;
  mesh.fields.push_back({.name = "f", .type = {}, .n_components = 1, .values = {}});
  for (std::uint32_t label = 0; label < hierarchy.n_labels(); ++label) {
    const Code code = hierarchy.code_of(label, field);
    mesh.positions.push_back(hierarchy.position(label, code));
    mesh.fields[0].values.push_back(hierarchy.value(label, code, field));
  }
  return mesh;
}

struct Built {
  TetraMesh reference;  ///< Its vertices by their labels.
  EdgeCollapses collapses;
  Hierarchy hierarchy;
  Forest forest;
  TetraMesh vertices;
};

inline Built built(const TetraMesh& mesh, std::uint64_t base_cells) {
  EdgeCollapses collapses = collapsed(mesh, base_cells);
  Hierarchy hierarchy = hierarchy_of(mesh, collapses);
  Forest forest(hierarchy);
  TetraMesh vertices = all_vertices(hierarchy);
  TetraMesh reference = test::labelled(mesh, hierarchy);
  return {std::move(reference), std::move(collapses), std::move(hierarchy), std::move(forest),
          std::move(vertices)};
}

}  // namespace lode::tetra_mt::midpoint
