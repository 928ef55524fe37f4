#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "lode/core/mesh.h"
#include "lode/core/surface.h"
#include "lode/core/tetra_mesh.h"

namespace lode::oracles {

/// With its first field, and no errors.
[[nodiscard]] inline SimplexMesh to_simplex_mesh(const TetraMesh& mesh) {
  SimplexMesh made;
  made.positions = mesh.positions;
  made.values = mesh.fields.front().values;
  made.tetrahedra = mesh.tetrahedra;
  made.errors.assign(mesh.tetrahedra.size(), 0.0F);
  return made;
}

/// Of a triangle: its corners' positions, turned so that they come first of the three ways.
using TriangleKey = std::array<std::array<float, 3>, 3>;

/// What a surface is, bit for bit, however its vertices and triangles are numbered.
[[nodiscard]] inline std::vector<TriangleKey> sorted_triangles(const Surface& surface) {
  std::vector<TriangleKey> keys;
  keys.reserve(surface.triangles.size());
  for (const auto& [a, b, c] : surface.triangles) {
    TriangleKey key{surface.positions[a].v, surface.positions[b].v, surface.positions[c].v};
    const TriangleKey second{key[1], key[2], key[0]};
    const TriangleKey third{key[2], key[0], key[1]};
    keys.push_back(std::min({key, second, third}));
  }
  std::ranges::sort(keys);
  return keys;
}

}  // namespace lode::oracles
