#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/core/surface_sink.h"
#include "lode/mappers/iso_part.h"
#include "lode/mappers/vertex_ids.h"

namespace lode {

/// One part with what it needs to be joined to others.
template <int D>
struct StitchPart {
  IsoPart<D> part;
  /// Vertices that other parts may have as well: their edges' doubled midpoints and local ids,
  /// sorted.
  std::vector<std::pair<LatticeKey, std::uint32_t>> shared;
  std::vector<Vec3f> normals;  ///< Of the part's points; PieceStitcher takes them along.
};

/// Lists the parts that may have a shared vertex, ascending.
using StitchCandidates =
    std::function<void(LatticeKey doubled_midpoint, std::vector<std::uint32_t>& out)>;

/// Fills part.shared: vertices whose edge satisfies is_shared(const EdgePoint&).
template <int D, typename IsShared>
void find_shared(StitchPart<D>& part, const IsShared& is_shared) {
  part.shared.clear();
  const auto& points = part.part.points;
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (is_shared(points[v])) part.shared.emplace_back(points[v].doubled_midpoint(), v);
  std::sort(part.shared.begin(), part.shared.end());
}

/// Where each vertex of the joined surface comes from, for normals.
struct VertexOrigin {
  std::uint32_t part = 0;
  std::uint32_t vertex = 0;
};

/// Joins parts into one surface, appended to `surface`. A shared vertex belongs to the first part
/// that has it, in order; `candidates(key, out)` lists the parts that may, ascending. The result
/// depends on nothing but the parts. Fails where 32 bits cannot number the vertices.
template <int D>
[[nodiscard]] Result<void> stitch(const std::vector<StitchPart<D>>& parts,
                                  const StitchCandidates& candidates, const LatticeFrame& frame,
                                  Threads threads, Surface& surface,
                                  std::vector<VertexOrigin>* origins);

/// stitch() for parts that come group by group, of which none need stay: all groups' pieces are the
/// surface that stitch() makes of all parts.
template <int D>
class PieceStitcher {
 public:
  /// first_vertex: the number of the first piece's first vertex.
  PieceStitcher(const LatticeFrame& frame, std::uint32_t first_vertex, Threads threads)
      : frame_(frame), threads_(threads), n_vertices_(first_vertex) {}

  /// The next parts' piece. `candidates` numbers them from 0; is_kept(key) says which vertices
  /// parts to come may have as well. Fails where 32 bits cannot number the vertices.
  [[nodiscard]] Result<SurfacePiece> join(const std::vector<StitchPart<D>>& parts,
                                          const StitchCandidates& candidates,
                                          const std::function<bool(LatticeKey)>& is_kept);
  /// Keeps no more than those vertices for parts to come.
  void forget_all_but(const std::function<bool(LatticeKey)>& is_kept);

 private:
  LatticeFrame frame_;
  Threads threads_;
  std::uint32_t n_vertices_;
  VertexIds kept_;                      ///< By doubled midpoint.
  std::vector<std::uint32_t> numbers_;  ///< Of kept_, in the whole surface.
};

}  // namespace lode
