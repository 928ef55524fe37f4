#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/closed_mesh.h"

namespace lode::tetra_mt {

/// Of collapses, one after the other: the star of each vertex before it went, and which collapses
/// had made the tetrahedra of it. About 160 bytes each.
struct CollapseStars {
  struct Size {
    std::uint8_t n_link = 0;
    std::uint8_t n_triangles = 0;
    std::uint8_t n_children = 0;
  };
  static constexpr std::uint8_t kReference = 0xFF;  ///< A tetrahedron that none has made.

  std::vector<Size> sizes;                             ///< By collapse.
  std::vector<std::uint32_t> link;                     ///< The mesh's vertices, and that outside.
  std::vector<std::array<std::uint8_t, 3>> triangles;  ///< Places in the link.
  std::vector<std::uint32_t> children;                 ///< Vertices whose collapses made some.
  std::vector<std::uint8_t> makers;                    ///< By triangle: a place in the children.
  std::vector<std::uint32_t> labels;                   ///< By triangle, where there are regions.
};

/// A tetrahedron of the base to the vertex outside.
struct OuterTetrahedron {
  Tetrahedron corners;                ///< The mesh's.
  std::array<std::uint32_t, 3> face;  ///< On which it was in the mesh.
  std::uint32_t maker;                ///< The vertex whose collapse made it, or kNone.
  std::uint32_t patch;                ///< patch_mark().
};

}  // namespace lode::tetra_mt
