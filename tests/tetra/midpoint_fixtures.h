#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <utility>

#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"

namespace lode::test {

/// A mesh with its vertices in the order of their labels.
inline TetraMesh labelled(const TetraMesh& mesh, const tetra_mt::midpoint::Hierarchy& hierarchy) {
  TetraMesh result = mesh;
  std::vector<std::uint32_t> labels(mesh.positions.size());
  for (std::uint32_t leaf = 0; leaf < labels.size(); ++leaf) {
    const std::uint32_t v = hierarchy.mesh_vertices[leaf];
    labels[v] = leaf;
    result.positions[leaf] = mesh.positions[v];
    result.fields[0].values[leaf] = mesh.fields[0].values[v];
  }
  for (auto& t : result.tetrahedra)
    for (std::uint32_t& v : t) v = labels[v];
  for (PatchFace& face : result.patch_faces)
    for (std::uint32_t& v : face.corners) v = labels[v];
  return result;
}

inline tetra_mt::midpoint::Hierarchy midpoints_of(const TetraMesh& mesh, std::uint64_t base_cells) {
  Progress progress;
  const auto collapses = tetra_mt::midpoint::collapse_edges(
      mesh, {.base_cells = base_cells, .threads = {2}}, progress);
  EXPECT_TRUE(collapses) << (collapses ? "" : collapses.error().message);
  auto hierarchy = tetra_mt::midpoint::make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy) << (hierarchy ? "" : hierarchy.error().message);
  return std::move(*hierarchy);
}

}  // namespace lode::test
