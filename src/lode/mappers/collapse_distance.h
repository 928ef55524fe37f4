#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/surface.h"
#include "lode/mappers/collapse_cover.h"
#include "lode/mappers/collapse_undo.h"
#include "lode/mappers/triangle_cuts.h"

namespace lode::simplification {

/// What a distance check found.
struct DistanceReport {
  double proven = 0;  ///< No point of the triangles looked at is farther, those that fail aside.
  std::vector<std::uint32_t> failing;  ///< Triangles without a proof.
};

/// Proves, in both directions, that no point is farther than a limit. A triangle, or a piece of it
/// where it is cut in four again and again, is near where its three corners are near one convex
/// set: the distance to such a set is a convex function. Original triangles are cut where they go
/// from one new triangle to another. New triangles are covered by shadows of original ones; where
/// they are not, pieces are held against single original vertices, and then against single original
/// triangles. No nearest point is searched for: attached vertices say where to look, and what is
/// not found there counts as failing.
class DistanceProof {
 public:
  /// `edge`: about the longest of original triangles; how far to look round original vertices.
  /// Where it is cancelled, reports are not complete.
  DistanceProof(const Surface& original, const CollapseMesh& mesh, const CollapseUndo& stars,
                double limit, double edge, const Progress& progress)
      : original_(original),
        mesh_(mesh),
        stars_(stars),
        limit_(limit),
        longest_edge_(static_cast<float>(edge)),
        progress_(progress),
        looked_around_(original.triangles.size(), 1) {}

  /// From all points of original triangles to the new surface. Of each it is remembered whether
  /// more was looked at than the triangles its corners are attached to.
  [[nodiscard]] DistanceReport from_original(std::span<const std::uint32_t> triangles,
                                             Threads threads);
  /// From all points of new triangles to the original surface.
  [[nodiscard]] DistanceReport to_original(std::span<const std::uint32_t> triangles,
                                           Threads threads);
  /// Whether the last proof of an original triangle depends on what is round those, too.
  [[nodiscard]] bool looked_around(std::uint32_t triangle) const {
    return looked_around_[triangle] != 0;
  }
  /// Original triangles round original vertices; found once.
  [[nodiscard]] Surroundings surroundings(Threads threads) {
    if (first_around_.empty()) find_triangles_around(threads);
    return {first_around_, around_};
  }

 private:
  using Corners = std::array<Vec3d, 3>;

  /// Of a thread.
  struct FromOriginal {
    TriangleCuts cuts;
    std::vector<std::uint32_t> around;
  };

  [[nodiscard]] double bound_from(std::uint32_t triangle, FromOriginal& own);
  [[nodiscard]] double bound_from_around(std::uint32_t triangle, FromOriginal& own) const;
  [[nodiscard]] double bound_from_one(std::uint32_t triangle) const;
  [[nodiscard]] double bound_to(std::uint32_t triangle, ShadowCover& shadows, Cover& cover) const;
  template <typename Add>
  void for_each_near(std::uint32_t triangle, const Add& add) const;
  [[nodiscard]] Corners original_corners(std::uint32_t triangle) const;
  [[nodiscard]] std::uint32_t vertex_near(std::uint32_t triangle) const;
  void find_distances(Threads threads);
  void find_triangles_around(Threads threads);

  const Surface& original_;
  const CollapseMesh& mesh_;
  const CollapseUndo& stars_;
  double limit_;
  float longest_edge_;
  const Progress& progress_;
  std::vector<std::uint32_t> first_around_;  ///< Original triangles round original vertices,
  std::vector<std::uint32_t> around_;        ///< once they are wanted.
  std::vector<double> attached_distance2_;   ///< Empty where it is not worth finding.
  std::vector<std::uint8_t> looked_around_;  ///< By original triangle; 1 where that is not known.
};

}  // namespace lode::simplification
