#pragma once

// Sheets of triangles, the boundary's and those between regions, held against others by brute
// force.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/mesh_checks.h"

namespace lode::test {

using Triangle = std::array<Vec3d, 3>;

inline double away_from_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const double t = dot(p - a, b - a) / dot(b - a, b - a);
  return length(p - (a + (b - a) * std::clamp(t, 0.0, 1.0)));
}

inline double away_from_triangle(const Vec3d& p, const Triangle& t) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  bool is_above = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d& a = t[i];
    const Vec3d& b = t[(i + 1) % 3];
    is_above = is_above && dot(cross(b - a, p - a), normal) >= 0;
    nearest = std::min(nearest, away_from_segment(p, a, b));
  }
  return is_above ? std::abs(dot(p - t[0], normal)) / length(normal) : nearest;
}

/// Of points all over triangles from others.
inline double farthest_from(const std::vector<Triangle>& triangles,
                            const std::vector<Triangle>& others) {
  constexpr int kSteps = 3;
  double farthest = 0;
  for (const Triangle& t : triangles)
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const Vec3d p = t[0] * (1.0 * i / kSteps) + t[1] * (1.0 * j / kSteps) +
                        t[2] * (1.0 * (kSteps - i - j) / kSteps);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Triangle& other : others)
          if (nearest > farthest) nearest = std::min(nearest, away_from_triangle(p, other));
        farthest = std::max(farthest, nearest);
      }
  return farthest;
}

/// Of the boundary, and between regions, by brute force.
inline std::vector<Triangle> sheets_of(const TetraMesh& mesh, const Tetrahedra& tetrahedra,
                                       std::span<const std::uint32_t> regions) {
  std::map<std::array<std::uint32_t, 3>, std::vector<std::uint32_t>> sides;
  for (std::size_t i = 0; i < tetrahedra.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      auto face = tetra_mt::others(tetrahedra[i], k);
      std::ranges::sort(face);
      sides[face].push_back(regions.empty() ? 0 : regions[i]);
    }
  std::vector<Triangle> sheets;
  for (const auto& [face, of] : sides)
    if (of.size() == 1 || of[0] != of[1])
      sheets.push_back({mesh.positions[face[0]], mesh.positions[face[1]], mesh.positions[face[2]]});
  return sheets;
}

/// A cube's points moved into the unit ball, cubes round the middle into spheres.
inline TetraMesh ball(int n) {
  TetraMesh mesh = oracles::noise_mesh(n, oracles::Cut::in_six, 2);
  for (Vec3d& p : mesh.positions) {
    p = (p - Vec3d{{0.5, 0.5, 0.5}}) * 2;
    const double size = length(p);
    const double largest = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    if (size > 0) p = p * (largest / size);
  }
  mesh.has_narrow_positions = false;
  std::erase_if(mesh.tetrahedra, [&](const auto& t) { return volume_of(mesh, {t}) < 1e-9; });
  return mesh;
}

}  // namespace lode::test
