#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/delaunay/lattice.h"
#include "lode/delaunay/tin.h"
#include "lode/locate/tin_locator.h"

namespace lode::triangle_hierarchy {

/// What a segment meets of a TIN between its ends: an edge that it crosses, or a vertex on it.
struct TinMeeting {
  std::uint32_t right = 0;     ///< The ends of the edge, on both sides of the segment;
  std::uint32_t left = 0;      ///< the same: the vertex.
  std::uint32_t triangle = 0;  ///< One that has them.

  [[nodiscard]] bool is_vertex() const { return right == left; }
};

/// Walks through a TIN along segments between nodes of a lattice 2^bits times as fine: all turns
/// are decided exactly, for fine coordinates of at most 30 bits.
class TinWalker {
 public:
  /// The TIN has twins; it and its locator outlive this. O(triangles), about 20 bytes a vertex.
  TinWalker(const delaunay::Tin& tin, const TinLocator& locator, int bits);

  /// Calls visit(meeting) for what is strictly between a and b, fine, in this order. A segment that
  /// leaves the TIN ends there, and one that does not begin in it has nothing. O(edges crossed +
  /// those of vertices met) and a location.
  template <typename Visit>
  void walk(delaunay::LatticePoint a, delaunay::LatticePoint b, const Visit& visit) const;

  /// The triangle that holds a fine place; kNoHalfEdge: none does.
  [[nodiscard]] std::uint32_t triangle_at(delaunay::LatticePoint fine) const;
  [[nodiscard]] delaunay::LatticePoint fine(std::uint32_t vertex) const {
    return {tin_.vertices[vertex].x << bits_, tin_.vertices[vertex].y << bits_};
  }

 private:
  /// Where a walk goes on: over an edge (4 times a triangle and its edge), out of the triangle, or
  /// at a vertex.
  struct Step {
    std::uint32_t half_edge = delaunay::kNoHalfEdge;
    std::uint32_t vertex = delaunay::kNoHalfEdge;
    std::uint32_t triangle = 0;  ///< That has the vertex.

    [[nodiscard]] bool is_end() const {
      return half_edge == delaunay::kNoHalfEdge && vertex == delaunay::kNoHalfEdge;
    }
  };
  struct Segment {
    delaunay::LatticePoint a;
    delaunay::LatticePoint b;
  };

  static constexpr std::array<std::uint32_t, 3> kNextCorner{1, 2, 0};

  [[nodiscard]] int side_of(const Segment& segment, std::uint32_t vertex) const;
  [[nodiscard]] bool is_ahead(const Segment& segment, delaunay::LatticePoint from,
                              delaunay::LatticePoint to) const;
  [[nodiscard]] Step start(const Segment& segment) const;
  [[nodiscard]] Step leave(const Segment& segment, std::uint32_t triangle) const;
  [[nodiscard]] Step leave_vertex(const Segment& segment, std::uint32_t vertex) const;
  [[nodiscard]] Step cross(const Segment& segment, std::uint32_t half_edge) const;
  [[nodiscard]] std::span<const std::uint32_t> triangles_round(std::uint32_t vertex) const {
    return {round_.data() + first_[vertex], round_.data() + first_[vertex + 1]};
  }

  const delaunay::Tin& tin_;
  const TinLocator& locator_;
  int bits_;
  std::vector<std::uint32_t> first_;  ///< By vertex, and one more, of its triangles.
  std::vector<std::uint32_t> round_;
};

template <typename Visit>
void TinWalker::walk(delaunay::LatticePoint a, delaunay::LatticePoint b, const Visit& visit) const {
  const Segment segment{a, b};
  for (Step step = start(segment); !step.is_end();) {
    if (step.vertex != delaunay::kNoHalfEdge) {
      if (!is_ahead(segment, fine(step.vertex), b)) return;
      visit(TinMeeting{step.vertex, step.vertex, step.triangle});
      step = leave_vertex(segment, step.vertex);
      continue;
    }
    const std::uint32_t triangle = step.half_edge / 4;
    const std::uint32_t edge = step.half_edge % 4;
    const std::uint32_t right = tin_.triangles[triangle][edge];
    const std::uint32_t left = tin_.triangles[triangle][kNextCorner[edge]];
    if (delaunay::doubled_area(fine(right), fine(left), b) >= 0) return;
    // Beyond an edge of the outline there is nothing.
    if (tin_.twins[triangle][edge] == delaunay::kNoHalfEdge) return;
    visit(TinMeeting{right, left, triangle});
    step = cross(segment, step.half_edge);
  }
}

}  // namespace lode::triangle_hierarchy
