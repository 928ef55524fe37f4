#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/iso_part.h"

namespace lode {

/// A vertex that other parts may have as well, by what makes it: a lattice edge, or the crossing
/// of a segment between two of them with a border plane.
struct SharedKey {
  LatticeKey first = 0;
  LatticeKey second = 0;  ///< 0 for a vertex on a lattice edge.
  std::uint32_t axis = 0;

  friend constexpr auto operator<=>(const SharedKey&, const SharedKey&) = default;
};

/// One part with what it needs to be joined to others.
template <int D>
struct StitchPart {
  IsoPart<D> part;
  std::vector<std::pair<SharedKey, std::uint32_t>> shared;  ///< Sorted; local vertex ids.
};

/// Fills part.shared: vertices whose edge satisfies `is_shared`, and clip points between two such.
template <int D>
void find_shared(StitchPart<D>& part, const std::function<bool(const EdgePoint&)>& is_shared);

/// Where each vertex of the joined surface comes from, for normals.
struct VertexOrigin {
  std::uint32_t part = 0;
  std::uint32_t vertex = 0;
};

/// Joins parts into one surface, appended to `surface`. A shared vertex belongs to the first part
/// that has it, in order; `candidates(key, out)` lists the parts that may, ascending. The result
/// depends on nothing but the parts. `limit_vertices` gets the vertices in planes that parts were
/// clipped at. Fails where 32 bits cannot number the vertices.
template <int D>
[[nodiscard]] Result<void> stitch(
    const std::vector<StitchPart<D>>& parts,
    const std::function<void(LatticeKey doubled_midpoint, std::vector<std::uint32_t>& out)>&
        candidates,
    const LatticeFrame& frame, Threads threads, Surface& surface,
    std::vector<VertexOrigin>* origins, std::vector<std::uint32_t>& limit_vertices);

}  // namespace lode
