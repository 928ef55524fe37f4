#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lode/core/height_points.h"
#include "lode/core/progress.h"

namespace lode::delaunay_selector {

/// The part of the plane that scattered points define a surface over, whatever the tolerance. All
/// numbers are of points.
struct PointDomain {
  /// Corners of the outline, turning left (x to the right, y up), constrained Delaunay: the
  /// coarsest triangulation that has the whole outline.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 2>> outline;  ///< Edges, the domain on their left.
  std::vector<std::array<std::uint32_t, 2>> lines;    ///< Inside; every TIN has them as edges.
  /// By point, one of the triangles that hold it; delaunay::kNoHalfEdge: it is left out.
  std::vector<std::uint32_t> triangle_of;
  std::uint64_t n_left_out = 0;
};

/// The convex hull. Fails on fewer than three points that are not on one line.
[[nodiscard]] Result<PointDomain> find_hull(const HeightPoints& points);

struct LinedDomain {
  PointDomain domain;
  std::vector<std::uint32_t> line_of;  ///< By edge of the domain's lines, the number of its line.
  std::uint64_t n_crossing = 0;        ///< Lines that are not whole.
};

/// A domain with lines in it, given as edges, and single points that every TIN is to have: the
/// triangles become those of delaunay::fix_lines(). Lines should meet at points only; of those that
/// cross the outline or others a part is missing. Fails when cancelled.
[[nodiscard]] Result<LinedDomain> with_lines(const HeightPoints& points, const PointDomain& domain,
                                             std::span<const std::array<std::uint32_t, 2>> lines,
                                             std::span<const std::uint32_t> single,
                                             Progress& progress);

/// Whether a triangle of points, turning left, is to be part of a domain.
using KeepTriangle = std::function<bool(const std::array<std::uint32_t, 3>&)>;

/// The union of those triangles of the Delaunay triangulation of all points that are kept. Its
/// outline is that of whole triangles; points that are corners of none are left out. Where points
/// lie on one circle there are several such triangulations: it is always the same one. Fails as
/// find_hull() does, where no triangle is kept, and when cancelled.
[[nodiscard]] Result<PointDomain> find_part(const HeightPoints& points, const KeepTriangle& keep,
                                            Progress& progress);

}  // namespace lode::delaunay_selector
