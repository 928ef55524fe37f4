#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/tetra_mesh.h"

namespace lode::test {

using Tetrahedra = std::vector<std::array<std::uint32_t, 4>>;

/// Expects every tetrahedron to have four corners and positive volume, each face one or two
/// tetrahedra, on different sides of it; returns the sum of volumes.
double expect_conforming(const TetraMesh& mesh, const Tetrahedra& tetrahedra);

/// The sum of volumes, negative ones too.
double volume_of(const TetraMesh& mesh, const Tetrahedra& tetrahedra);

/// F' at a point, by brute force: of all tetrahedra, or of those round whose corners a box holds
/// it, where one does, that in which the smallest weight is largest.
struct Located {
  double least_weight;
  double value;
  std::size_t cell = 0;
};
Located locate(const TetraMesh& mesh, const Tetrahedra& tetrahedra, const Vec3d& p,
               std::size_t field);

/// Does collapses by their definition, one after the other.
Tetrahedra replay(const Tetrahedra& tetrahedra,
                  std::span<const std::array<std::uint32_t, 2>> collapses);

/// The same tetrahedra whatever the order of them, and of corners but for orientation.
Tetrahedra normalised(Tetrahedra tetrahedra);

}  // namespace lode::test
