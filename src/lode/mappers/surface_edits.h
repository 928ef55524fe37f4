#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

/// What an edit took away.
struct Dropped {
  std::uint64_t components = 0;
  std::uint64_t cells = 0;
};

/// Gives each fan of cells round a vertex its own copy of it: where holes or a crop
/// box pinch the domain, cells that share no edge must not share the vertex. Attributes are copied;
/// copies are numbered in the order of their cells. O(n log n).
void split_pinched_vertices(Surface& surface);

/// How far beside a plane of the box a cropped surface's vertices may lie: 8 to 16 units in the
/// last place of float32 at its largest coordinate, which may be that of another axis. bounds: what
/// the surface lies in; origin: its own.
[[nodiscard]] double crop_rounding(const Box3d& box, const Box3d& bounds, const Vec3d& origin);

/// Keeps the part inside the box (world units) or in its planes; the cut is straight and shared by
/// both cells. Vertices within crop_rounding() of a plane count as in it, and stay where they are.
/// Errors, regions and patches are those of the cells that are cut.
void crop(Surface& surface, const Box3d& box);

/// Drops connected pieces of fewer than n cells.
[[nodiscard]] Dropped drop_small_components(Surface& surface, std::uint64_t n);

/// The components of a surface of triangles.
struct ComponentNumbers {
  std::vector<std::uint32_t> of_vertex;  ///< Numbered by their lowest vertices.
  std::uint32_t n = 0;
};
[[nodiscard]] ComponentNumbers number_components(const Surface& surface);

/// Drops those components of a surface of triangles that are marked, by number.
[[nodiscard]] Dropped drop_components(Surface& surface, const ComponentNumbers& numbers,
                                      std::span<const std::uint8_t> is_marked);

/// Turns triangles (lines) and normals round.
void flip_orientation(Surface& surface);

}  // namespace lode
