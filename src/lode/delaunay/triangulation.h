#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/predicates.h"

namespace lode::delaunay {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A triangle, counter-clockwise. Its edge i runs from corner i + 1 to corner i + 2; behind it is
/// neighbour i.
struct Triangle {
  std::array<std::uint32_t, 3> corner;
  std::array<std::uint32_t, 3> neighbour{kNone, kNone, kNone};
  std::array<bool, 3> is_fixed{};  ///< Edge i is a constraint.
};

struct FixedRegion;

/// The constrained Delaunay triangulation of points in the plane: of all triangulations of their
/// convex hull that contain the fixed edges, the one whose other edges are all locally Delaunay.
/// All decisions are exact; ties (cocircular points) are settled by the order of insertion.
class Triangulation {
 public:
  /// Delaunay, with nothing fixed yet: points are added from left to right, O(n log n) and the
  /// flips. Fails where two points coincide. No triangles when all points are on one line.
  [[nodiscard]] static Result<Triangulation> of(std::vector<Point> points);

  /// Makes a-b an edge, by flips (Sloan 1993), and keeps it. Fails, naming points, where it
  /// crosses a fixed edge or runs through a point.
  [[nodiscard]] Result<void> fix_edge(std::uint32_t a, std::uint32_t b);

  /// Makes all of the segment a-b edges, through the points that lie on it, which are returned from
  /// a to b; up to the last before a fixed edge that is in the way, and no further.
  [[nodiscard]] std::vector<std::uint32_t> fix_path(std::uint32_t a, std::uint32_t b);

  /// Which triangles lie in the region to the left of edges that have been fixed. Fails where the
  /// region is not closed, or on both sides of an edge.
  [[nodiscard]] Result<std::vector<bool>> left_of(
      std::span<const std::array<std::uint32_t, 2>> edges) const;

  /// Leaves edges of lines out that are in none of those triangles, and counts their lines as not
  /// whole.
  void leave_out_edges(const std::vector<bool>& is_inside, FixedRegion& region) const;

  /// Of those triangles.
  [[nodiscard]] std::vector<std::array<std::uint32_t, 3>> corners(
      const std::vector<bool>& is_kept) const;
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  /// A triangle and one of its edges.
  struct Place {
    std::uint32_t triangle = kNone;
    unsigned edge = 0;
  };
  using Ends = std::array<std::uint32_t, 2>;
  class Sweep;

  explicit Triangulation(std::vector<Point> points) : points_(std::move(points)) {}

  [[nodiscard]] int turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return orientation(points_[a], points_[b], points_[c]);
  }
  [[nodiscard]] unsigned index_of(std::uint32_t triangle, std::uint32_t corner) const;
  [[nodiscard]] Place mirror(const Place& place) const;
  void link(const Place& a, const Place& b);
  void flip(const Place& place);
  void make_delaunay(std::vector<Place>& suspects);
  [[nodiscard]] bool is_illegal(const Place& place) const;

  /// Calls visit(triangle) for the triangles round a point until it returns true.
  template <typename Visit>
  void visit_round(std::uint32_t point, const Visit& visit) const;
  /// The edge a -> b; its triangle is kNone where there is none.
  [[nodiscard]] Place find_edge(std::uint32_t a, std::uint32_t b) const;
  /// Along a segment.
  struct Course {
    std::vector<Ends> crossed{};  ///< All edges up to the first point on it.
    std::uint32_t end = kNone;    ///< That point.
  };
  /// The segment from a to b: either its first point is beside a, or it crosses the edge `first`,
  /// of the triangle at a, opposite a.
  [[nodiscard]] Course start_course(std::uint32_t a, std::uint32_t b, Place& first) const;
  /// Fails at fixed edges.
  [[nodiscard]] Result<Course> find_course(std::uint32_t a, std::uint32_t b) const;
  void fix_course(std::uint32_t a, Course course);
  void flip_crossed(std::uint32_t a, std::uint32_t b, std::vector<Ends> crossed);
  [[nodiscard]] bool crosses(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                             std::uint32_t d) const;

  std::vector<Point> points_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> triangle_of_;  ///< Per point: one of its triangles.
};

/// Triangulates the region to the left of directed edges: closed chains that meet only at their
/// points. The triangles use the given points only, are counter-clockwise and of positive area.
/// Fails where edges cross, or where the two sides of an edge are both inside or contradict each
/// other.
[[nodiscard]] Result<std::vector<std::array<std::uint32_t, 3>>> triangulate_region(
    std::vector<Point> points, std::span<const std::array<std::uint32_t, 2>> edges);

/// Triangles with lines among their edges.
struct FixedRegion {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< Of the lines, cut at points on them.
  std::vector<std::uint32_t> line_of;               ///< By edge, the number of its line.
  std::vector<std::uint32_t> crossing;  ///< Numbers of lines that are not whole; see below.
};

/// The same with lines, given as edges, in the region. All may run through points. Of a line that
/// crosses the outline or an earlier line nothing is kept between the last points before that, seen
/// from both of its ends, nor what lies outside. Each takes as long as there are triangles at its
/// ends, besides those it crosses. Fails when cancelled.
[[nodiscard]] Result<FixedRegion> triangulate_region(
    std::vector<Point> points, std::span<const std::array<std::uint32_t, 2>> outline,
    std::span<const std::array<std::uint32_t, 2>> lines, Progress& progress);

}  // namespace lode::delaunay
