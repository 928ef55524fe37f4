#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/closed_mesh.h"

namespace lode::tetra_mt {

/// What triangles cut out of the tetrahedra of a reference mesh, on which F is linear: on a
/// triangle with an F' that is linear, too, F - F' is extreme where the triangle crosses edges of
/// the mesh, where edges of the triangle cross faces, at vertices of the mesh in it, and at its
/// corners.
///
/// One goes from tetrahedron to tetrahedron over faces that the triangle crosses, from one at a
/// corner of it, so what is looked at is what it meets, and no more. The triangle's inside is
/// connected, so nothing is left out where it is in the domain. Where it goes out of that at all
/// its corners, as may those of boundaries that are not quite flat, all tetrahedra are looked at
/// whose boxes it meets.
class ReferenceOverlay {
 public:
  /// What a thread needs: 4 bytes a tetrahedron.
  struct Scratch {
    std::vector<std::uint32_t> seen;  ///< By tetrahedron: the last triangle that met it.
    std::uint32_t n_triangles = 0;
    std::vector<std::uint32_t> next;  ///< To be looked at.
    std::vector<double> differences;  ///< By corner of a tetrahedron and field.
  };

  /// The mesh stays the caller's. `slack`: how far a triangle with all corners on the boundary may
  /// be from it.
  ReferenceOverlay(const TetraMesh& mesh, double slack);

  /// By field, the largest |F - F'| on a triangle of vertices of the mesh between whose values F'
  /// is linear, rounded up. False, and nothing, where it has next to no area.
  [[nodiscard]] bool largest_differences(const std::array<std::uint32_t, 3>& corners,
                                         std::span<double> largest, Scratch& scratch) const;

 private:
  struct Triangle;
  struct Meeting;
  struct Segment;

  [[nodiscard]] std::uint32_t find_first(const Triangle& triangle) const;
  [[nodiscard]] Meeting meet(const Triangle& triangle, const Tetrahedron& corners,
                             std::span<double> differences) const;
  [[nodiscard]] static Segment segment_of(const Meeting& met, std::size_t face);
  void add_all_near(const Triangle& triangle, std::vector<std::uint32_t>& found) const;
  void visit(const Triangle& triangle, std::uint32_t tetrahedron, std::span<double> largest,
             Scratch& scratch) const;

  const TetraMesh& mesh_;
  double slack_;
  std::vector<std::array<std::uint32_t, 4>> across_;
  std::vector<std::uint64_t> star_begins_;  ///< By vertex, and one more.
  std::vector<std::uint32_t> stars_;        ///< Tetrahedra round it.
  std::vector<std::uint8_t> is_on_boundary_;
  std::vector<double> scales_;  ///< By field: its largest value.
};

}  // namespace lode::tetra_mt
