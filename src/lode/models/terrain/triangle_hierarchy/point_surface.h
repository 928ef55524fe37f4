#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/core/height_frame.h"
#include "lode/delaunay/tin.h"
#include "lode/locate/tin_locator.h"
#include "lode/models/terrain/triangle_hierarchy/point_tree.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"
#include "lode/models/terrain/triangle_hierarchy/tin_walk.h"

namespace lode::triangle_hierarchy {

/// Scattered points, linear in the triangles of a TIN that has all of them as vertices. The profile
/// of an edge is read where it crosses edges of the TIN, and at points on it. A crossing that
/// becomes a vertex is moved to the nearest node of the finer lattice, and has the TIN's height
/// there.
class PointSurface final : public ReferenceSurface {
 public:
  /// `all`: with twins and heights, vertices in rows, below 2^30; within delaunay::check_heights().
  /// `base`: triangles of the same domain, in points. O(n log n); about 150 bytes a point.
  PointSurface(const HeightFrame& frame, delaunay::Tin all,
               std::span<const std::array<LatticePoint, 3>> base);
  PointSurface(const PointSurface&) = delete;
  PointSurface& operator=(const PointSurface&) = delete;
  ~PointSurface() override = default;

  [[nodiscard]] const delaunay::Tin& tin() const { return tin_; }

  [[nodiscard]] bool is_of_points() const override { return true; }
  /// At any fine node of the domain: at points exactly, elsewhere between the corners of a
  /// triangle, and never beyond them.
  [[nodiscard]] double height(LatticePoint fine) const override;
  /// Of equal errors the first counts, from the end that is first in rows. Crossings that would
  /// move to a node farther from one end than the other is are none: they are less than a node from
  /// an end. O(edges crossed) and locations.
  [[nodiscard]] EdgeSplit worst_crossing(Place a, Place b,
                                         Crossings crossings = Crossings::all) const override;
  [[nodiscard]] SampleErrors measure_samples(const std::array<Place, 3>& corners,
                                             EdgeSet open) const override;
  [[nodiscard]] bool has_samples_beside(const std::array<LatticePoint, 3>& corners,
                                        std::int32_t reach) const override;
  [[nodiscard]] std::size_t count_samples(
      const std::array<LatticePoint, 3>& corners) const override;

 private:
  /// Where an edge meets the TIN.
  struct Crossing {
    double height = 0;
    double share = 0;  ///< Of the edge, from its first end.
  };

  [[nodiscard]] Crossing read(const Place& a, const Place& b, const TinMeeting& meeting) const;
  /// The node next to it, and whether that is on the edge.
  [[nodiscard]] EdgeSplit place_of(const Place& a, const Place& b, const TinMeeting& meeting) const;
  [[nodiscard]] double height_in(std::uint32_t triangle, LatticePoint fine) const;

  delaunay::Tin tin_;
  TinLocator locator_;
  TinWalker walker_;
  PointTree tree_;
};

}  // namespace lode::triangle_hierarchy
