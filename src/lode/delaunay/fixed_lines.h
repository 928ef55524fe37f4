#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/triangulation.h"

namespace lode::delaunay {

/// The coarsest constrained Delaunay triangulation of a domain with lines in it: of the corners of
/// its outline, the ends of edges, and single nodes. All numbers are of nodes. `triangles`: that
/// together are the domain, as of GridDomain. Edges should meet each other and the outline at such
/// nodes only: see triangulate_region(). Fails when cancelled.
template <typename Nodes>
[[nodiscard]] Result<FixedRegion> fix_lines(const Nodes& nodes,
                                            std::span<const std::array<std::uint32_t, 3>> triangles,
                                            std::span<const std::array<std::uint32_t, 2>> edges,
                                            std::span<const std::uint32_t> single,
                                            Progress& progress);

}  // namespace lode::delaunay
