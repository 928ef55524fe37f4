#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/triangulation.h"

namespace lode::delaunay {

/// The coarsest constrained Delaunay triangulation of a domain with lines in it: of the corners of
/// its outline and the ends of edges. All numbers are of nodes. `triangles`: that together are the
/// domain, as of GridDomain. Edges may meet each other and the outline at such nodes only; those on
/// the outline are no lines, and left out. O(n log n), and the edges that lines cross. Fails where
/// edges cross each other or the outline.
template <typename Nodes>
[[nodiscard]] Result<FixedRegion> fix_lines(const Nodes& nodes,
                                            std::span<const std::array<std::uint32_t, 3>> triangles,
                                            std::span<const std::array<std::uint32_t, 2>> edges);

}  // namespace lode::delaunay
