#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// A contour line of a TIN, in columns and rows. Of a ring, the last point is the first.
struct ContourLine {
  std::uint32_t level = 0;  ///< Which of those asked for.
  bool is_ring = false;
  std::vector<delaunay::Point> points;  ///< At least two, and no two equal ones follow each other.
  std::uint32_t triangle = 0;           ///< The first that it crosses.
  /// Of no ring: edges of the outline, 4 times a triangle and its edge.
  std::uint32_t begin = delaunay::kNoHalfEdge;
  std::uint32_t end = delaunay::kNoHalfEdge;
};

/// Contours of a TIN: the borders of {z >= level}, higher ground on the left (x to the right, y
/// up).
///
/// A vertex at a level counts as above it: so a line crosses an edge or does not, never runs
/// along flat triangles of its height, and passes vertices of its height on their lower side, where
/// the crossings of several edges fall into one point. In the limit of that rule lines neither
/// branch nor cross: they may meet at such vertices, run along an edge at their height once on
/// either side (a ridge that falls on both), and touch. Lines end at the outline only. Points are
/// left out where they equal the one before, and lines of one point alone (a peak of this height).
struct ContourSet {
  std::vector<ContourLine> lines;  ///< By levels, as they come in `levels`.
  std::uint64_t n_points = 0;
  std::uint64_t n_left_out = 0;  ///< Lines of one point.
};

/// all: also those of one point.
enum class KeptLines : std::uint8_t { drawable, all };

/// Levels rise strictly and are finite; the TIN has twins and heights. Each line is followed once
/// from triangle to triangle, and each point computed once: no crack. O(triangles + points). Fails
/// when cancelled.
[[nodiscard]] Result<ContourSet> trace_contours(const delaunay::Tin& tin,
                                                std::span<const double> levels, KeptLines kept,
                                                Progress& progress);

}  // namespace lode
