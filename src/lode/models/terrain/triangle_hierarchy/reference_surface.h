#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/delaunay/lattice.h"

namespace lode::triangle_hierarchy {

using delaunay::LatticePoint;

/// A vertex of a triangulation over a reference surface.
struct Place {
  LatticePoint at;  ///< Fine.
  double height = 0;
};

/// Where the profile of an edge is furthest from it.
struct EdgeSplit {
  double error = 0;       ///< 0: it has no crossing between its ends, or errs at none.
  Place place;            ///< The crossing, moved onto the fine lattice.
  bool is_exact = false;  ///< The place lies on the edge.
};

/// Which crossings may become vertices.
enum class Crossings : std::uint8_t {
  all,
  exact  ///< Those whose places are on the edge alone, so all samples on it.
};

/// Edges of a triangle; bit i: the one from corner i to corner i + 1.
using EdgeSet = std::uint8_t;
inline constexpr EdgeSet kNoEdges = 0;
inline constexpr EdgeSet kAllEdges = 7;

struct SampleErrors {
  double closed = 0;  ///< The largest of all samples in the closed triangle.
  double inner = 0;   ///< The largest of those that may be inserted,
  LatticePoint at;    ///< and where that is, fine, if it is not 0; the first in rows of equals.
};

/// What triangles are held against: samples at nodes of a lattice, and a surface that is linear
/// between them in parts. Vertices of triangles are nodes of a lattice scale() = 2^bits() times as
/// fine, of at most 30 bits a side. Const members are safe from many threads.
class ReferenceSurface {
 public:
  virtual ~ReferenceSurface() = default;

  /// See Hierarchy::is_of_points.
  [[nodiscard]] virtual bool is_of_points() const = 0;
  [[nodiscard]] const HeightFrame& frame() const { return frame_; }
  [[nodiscard]] int bits() const { return bits_; }
  [[nodiscard]] std::int32_t scale() const { return std::int32_t{1} << bits_; }
  [[nodiscard]] LatticePoint fine(LatticePoint sample) const {
    return {sample.x << bits_, sample.y << bits_};
  }
  /// The coarsest triangulation of the domain, of samples; fine nodes.
  [[nodiscard]] const std::vector<std::array<LatticePoint, 3>>& base() const { return base_; }
  /// Errors count as beyond a tolerance where they are by more than this, 2^-50 of the largest
  /// |height|, so that planes are not refined for rounding.
  [[nodiscard]] double slack() const { return slack_; }
  /// More than computed errors may be off: docs/models/hierarchical_triangulations.md.
  [[nodiscard]] double rounding() const { return 3 * slack_; }

  /// At a sample; fine.
  [[nodiscard]] virtual double height(LatticePoint fine) const = 0;
  /// The error of an edge, as the models of paper 004, section 7, want it: the surface above it,
  /// its profile, is read where it crosses the borders of linear parts, and held against the edge.
  /// From the edge alone, whichever end comes first, so that both triangles at it agree. The place
  /// is nearer to both ends than these are to each other.
  [[nodiscard]] virtual EdgeSplit worst_crossing(Place a, Place b,
                                                 Crossings crossings = Crossings::all) const = 0;
  /// |z - z'| at all samples in a triangle that turns left, z' between its corners. Those that may
  /// be inserted lie inside, or on an edge in `open`, and at no corner. Each sample is found
  /// exactly, and its error is off by less than rounding(), however thin the triangle is.
  [[nodiscard]] virtual SampleErrors measure_samples(const std::array<Place, 3>& corners,
                                                     EdgeSet open) const = 0;
  /// Whether samples may lie out of a triangle, but not farther than `reach` in columns and rows.
  /// Of points alone.
  [[nodiscard]] virtual bool has_samples_beside(const std::array<LatticePoint, 3>& corners,
                                                std::int32_t reach) const = 0;
  /// Of the closed triangle.
  [[nodiscard]] virtual std::size_t count_samples(
      const std::array<LatticePoint, 3>& corners) const = 0;

 protected:
  ReferenceSurface() = default;
  ReferenceSurface(const ReferenceSurface&) = default;
  ReferenceSurface(ReferenceSurface&&) = default;
  ReferenceSurface& operator=(const ReferenceSurface&) = default;
  ReferenceSurface& operator=(ReferenceSurface&&) = default;

  void set_frame(const HeightFrame& frame, int bits) {
    frame_ = frame;
    bits_ = bits;
  }
  void set_base(std::vector<std::array<LatticePoint, 3>> base) { base_ = std::move(base); }
  void set_range(const HeightRange& range);

 private:
  HeightFrame frame_;
  int bits_ = 0;
  double slack_ = 0;
  std::vector<std::array<LatticePoint, 3>> base_;
};

/// Twice the areas between a sample in a triangle and its edges, exactly.
struct SampleWeights {
  std::array<std::int64_t, 3> of_edge;

  /// Whether the sample is inside, or on one edge, which is open.
  [[nodiscard]] bool may_be_inserted(EdgeSet open) const {
    int n_on = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (of_edge[i] == 0) {
        if ((open >> i & 1) == 0) return false;
        ++n_on;
      }
    return n_on < 2;
  }
};

}  // namespace lode::triangle_hierarchy
