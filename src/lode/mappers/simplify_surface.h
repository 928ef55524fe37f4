#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/surface_band.h"

namespace lode {

/// A box that may be oblique: 0 <= dot(along[i], p) + at[i] <= most[i] of all points p in it.
struct ConvexDomain {
  std::array<Vec3d, 3> along;
  Vec3d at;
  Vec3d most;

  [[nodiscard]] bool has(const Vec3d& p) const {
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = dot(along[i], p) + at[i];
      if (!(x >= 0 && x <= most[i])) return false;
    }
    return true;
  }
};

struct SimplifyOptions {
  double max_distance = 0;            ///< > 0, in the unit of positions; infinite only with a band.
  const SurfaceBand* band = nullptr;  ///< That the surface lies in, and is to stay in.
  /// Only edges up to this length collapse: with that of max_distance slivers that have a short
  /// edge go, and triangles beside them change shape.
  double longest_edge = std::numeric_limits<double>::infinity();
  const ConvexDomain* domain = nullptr;  ///< Of positions, that vertices which move may not leave.
  Threads threads = {};
};

struct SimplifySeconds {
  double collapse = 0;
  double check = 0;  ///< Proofs, and taking back collapses that failed them.
  double finish = 0;
};

struct SimplifyReport {
  double max_distance = 0;  ///< As asked for.
  /// Of max_distance and proven_distance what lies between the surface before and what that stands
  /// for.
  double start_distance = 0;
  std::uint64_t triangles_before = 0;  ///< Of what collapses begin with.
  std::uint64_t triangles = 0;
  std::uint64_t collapses = 0;  ///< Edges that stay collapsed.
  std::uint64_t undone = 0;     ///< Collapses taken back because a proof failed.
  double proven_distance = 0;   ///< No point of either surface is farther from the other. Proofs
                                ///< stop at what was asked for: 0, or hardly less than that.
  double max_error = 0;         ///< The band's, or 0.
  double proven_error = 0;      ///< |F - c| of triangles that collapses made is at most this.
  std::uint64_t components_dropped = 0;  ///< In the band, before: drop_components_in_band().
  std::uint64_t triangles_dropped = 0;   ///< Theirs.
  std::uint64_t input_crossings = 0;     ///< Pairs of triangles that met before, and still do.
  bool by_pieces = false;  ///< One after the other: seams between them keep more triangles.
  SimplifySeconds seconds;

  /// Of both surfaces, or pieces of one, together.
  void join(const SimplifyReport& other);
};

/// Collapses edges of a surface of triangles for as long as it stays near. Guaranteed of the
/// result, whatever the input's shape:
/// - no point of either surface is farther than `max_distance` from the other, and than
///   `proven_distance`, where that is finite;
/// - in a domain, nothing is outside of it where nothing was;
/// - with a band, triangles that are not the input's lie in it, and no sample outside it is on
///   another side of the surface than before;
/// - it is homeomorphic to the input, component by component (the link condition, edge by edge), so
///   none vanishes, and closed ones of some volume enclose the side that they did; the border
///   stays, and no vertex of it moves: some go, and only where the border stays in all the
///   coordinate planes it runs in;
/// - no two triangles meet but in a common corner or edge, and none has zero area, exactly for its
///   float coordinates: unless they did so in the input.
/// Collapses are tried by quadric error, block by block in parallel, then the result is proven
/// triangle by triangle, and collapses are taken back where that fails. The same bytes come of any
/// number of threads. Vertices keep their order; normals are means of those that went into one,
/// isovalues those of one of them.
/// Expects a well-formed, oriented manifold without values, origins or errors; fails when
/// cancelled, or of more than 800 million triangles, and leaves the surface as it was. Proofs
/// take most of the time, and all the more where the distance is far below an edge.
[[nodiscard]] Result<SimplifyReport> simplify_surface(Surface& surface,
                                                      const SimplifyOptions& options,
                                                      Progress& progress);

inline constexpr std::uint32_t kGone = 0xFFFFFFFFU;

/// The same for a piece of a surface that is too large for memory. Its border stays as it is,
/// vertex by vertex and edge by edge, and what moves stays strictly inside the box of its vertices.
/// So pieces that lay in boxes with disjoint interiors fit together afterwards, and meet nowhere
/// else, if none had a vertex on its box that is not on its border: what is guaranteed of each
/// piece holds of the whole. `numbers`: by vertex before, its number afterwards, or kGone.
[[nodiscard]] Result<SimplifyReport> simplify_piece(Surface& surface,
                                                    const SimplifyOptions& options,
                                                    std::vector<std::uint32_t>& numbers,
                                                    Progress& progress);

}  // namespace lode
