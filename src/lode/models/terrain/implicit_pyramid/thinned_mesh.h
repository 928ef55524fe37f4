#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/tin.h"

namespace lode::implicit_pyramid {

/// A Delaunay triangulation that vertices are removed from, one by one.
class ThinnedMesh {
 public:
  /// With twins. A vertex that is a corner of the outline must not be removed.
  explicit ThinnedMesh(delaunay::Tin tin);

  [[nodiscard]] const delaunay::Tin& tin() const { return tin_; }
  /// Those joined to a vertex, turning left round it; of one on the outline from the one after it
  /// to the one before. Valid until the next call.
  [[nodiscard]] const std::vector<std::uint32_t>& neighbours(std::uint32_t vertex);
  /// Fills the hole that a vertex leaves, Delaunay. Of holes with several such fillings, whose
  /// vertices are on one circle, one that depends on the hole alone.
  void remove(std::uint32_t vertex);

 private:
  /// An edge of the hole, from a vertex to that of the next one; what is behind it.
  struct HoleEdge {
    std::uint32_t from;
    std::uint32_t twin;
  };

  void walk_round(std::uint32_t vertex);
  void fill_hole();
  /// The hole's edge that begins an ear: with the one after it a triangle that is Delaunay.
  [[nodiscard]] std::size_t find_ear() const;
  /// How many of the hole's other vertices are in the circle of an ear; kNoEar: it is none.
  [[nodiscard]] std::size_t count_inside(std::size_t ear) const;
  void set(std::uint32_t t, const std::array<std::uint32_t, 3>& corner,
           const std::array<std::uint32_t, 3>& twin);

  delaunay::Tin tin_;
  std::vector<std::uint32_t> triangle_of_;  ///< By vertex: one of its triangles.
  std::vector<std::uint32_t> ring_;
  std::vector<std::uint32_t> star_;  ///< Triangles round the vertex.
  std::vector<HoleEdge> hole_;
};

}  // namespace lode::implicit_pyramid
