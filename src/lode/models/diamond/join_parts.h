#pragma once

#include <span>
#include <vector>

#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/normals.h"

namespace lode::diamond {

/// Appends the surface of parts in memory: part 0 has everything coarser than bricks, the others
/// are those that `of_bricks` numbers.
template <int D>
[[nodiscard]] Result<void> join_parts(const Model<D>& model, const LatticeFrame& frame,
                                      const IsosurfaceQuery& query,
                                      const std::vector<StitchPart<D>>& parts,
                                      const PartsOfBricks<D>& of_bricks, Surface& surface) {
  std::vector<VertexOrigin> origins;
  const std::size_t first_new = surface.positions.size();
  LODE_CHECK(stitch<D>(
      parts,
      [&](LatticeKey key, std::vector<std::uint32_t>& out) { of_bricks.candidates(key, out); },
      frame, query.threads, surface, query.with_normals ? &origins : nullptr));
  if (!query.with_normals) return {};
  std::vector<EdgePoint> points(surface.positions.size() - first_new);
  for (std::size_t v = 0; v < points.size(); ++v)
    points[v] = parts[origins[first_new + v].part].part.points[origins[first_new + v].vertex];
  surface.normals.resize(surface.positions.size());
  compute_normals<D>(model, points, query.threads, std::span(surface.normals).subspan(first_new));
  return {};
}

}  // namespace lode::diamond
