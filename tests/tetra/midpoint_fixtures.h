#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
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
    for (std::size_t f = 0; f < mesh.fields.size(); ++f)
      result.fields[f].values[leaf] = mesh.fields[f].values[v];
  }
  for (auto& t : result.tetrahedra)
    for (std::uint32_t& v : t) v = labels[v];
  for (PatchFace& face : result.patch_faces)
    for (std::uint32_t& v : face.corners) v = labels[v];
  return result;
}

/// A mesh with further fields: waves, whose values no steps hold; the height of a plane, of which
/// F' is F; one with a far range, and one that is the same everywhere.
inline TetraMesh with_fields(TetraMesh mesh) {
  const auto add = [&](const char* name, const auto& f) {
    MeshField& field = mesh.fields.emplace_back();
    field = {.name = name, .type = ScalarType::float64, .n_components = 1, .values = {}};
    for (const Vec3d& p : mesh.positions) field.values.push_back(f(p));
  };
  add("waves", [](const Vec3d& p) { return std::sin(9 * p[0]) * std::cos(7 * p[1] + p[2]) / 3; });
  add("tilt", [](const Vec3d& p) { return 3 * p[0] - 2 * p[1] + 0.5 * p[2] + 7; });
  add("far", [](const Vec3d& p) { return 1e9 + 1e-3 * std::sin(5 * p[2] - 3 * p[1] * p[0]); });
  add("level", [](const Vec3d&) { return -0.0; });
  return mesh;
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
