#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/iso_part.h"

namespace lode {

/// One part with what it needs to be joined to others.
template <int D>
struct StitchPart {
  IsoPart<D> part;
  /// Vertices that other parts may have as well: their edges' doubled midpoints and local ids,
  /// sorted.
  std::vector<std::pair<LatticeKey, std::uint32_t>> shared;
};

/// Fills part.shared: vertices whose edge satisfies `is_shared`.
template <int D>
void find_shared(StitchPart<D>& part, const std::function<bool(const EdgePoint&)>& is_shared);

/// Where each vertex of the joined surface comes from, for normals.
struct VertexOrigin {
  std::uint32_t part = 0;
  std::uint32_t vertex = 0;
};

/// Joins parts into one surface, appended to `surface`. A shared vertex belongs to the first part
/// that has it, in order; `candidates(key, out)` lists the parts that may, ascending. The result
/// depends on nothing but the parts. Fails where 32 bits cannot number the vertices.
template <int D>
[[nodiscard]] Result<void> stitch(
    const std::vector<StitchPart<D>>& parts,
    const std::function<void(LatticeKey doubled_midpoint, std::vector<std::uint32_t>& out)>&
        candidates,
    const LatticeFrame& frame, Threads threads, Surface& surface,
    std::vector<VertexOrigin>* origins);

}  // namespace lode
