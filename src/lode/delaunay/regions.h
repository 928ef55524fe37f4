#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// A part of a mesh: a mesh of its own, whose border to other parts is not to be split.
struct Region {
  LatticeTriangles triangles;
  /// Border edges, by border_key(), and their half-edges; those change with what is inserted.
  std::unordered_map<std::uint64_t, std::uint32_t> border;
};

/// From one corner to another, with the region to the left.
[[nodiscard]] inline std::uint64_t border_key(std::uint32_t from, std::uint32_t to) {
  return (std::uint64_t{from} << 32) | to;
}

/// Cuts a mesh into regions, about as many triangles each, along edges near columns and rows. Where
/// it has too few triangles for two, there are none. The same for any number of threads.
[[nodiscard]] std::vector<Region> cut_into_regions(const LatticeMesh& mesh);

/// Joins regions, whose border edges are what they were, and empties them. `border` becomes the
/// half-edges of one side of each.
[[nodiscard]] LatticeTriangles join_regions(std::vector<Region>& regions, Threads threads,
                                            std::vector<std::uint32_t>& border);

}  // namespace lode::delaunay
