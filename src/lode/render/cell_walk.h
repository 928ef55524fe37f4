#pragma once

#include <array>
#include <cstdint>

#include "lode/render/volume_view.h"

namespace lode {

/// A line of sight on its way through the cells, from face to face.
///
/// A vertex is placed relative to the line: u right and v up of it at the vertex's own depth, cut
/// to 26 bits. So u v' - u' v of two vertices has an exact sign, and all cells agree on which side
/// of an edge the line runs; where it is zero the line counts as moved by (e, e^2) for a tiny e >
/// 0. Then a cell's outline in the plane is met by exactly none or two of its faces: from an outer
/// face that the line meets the walk takes each cell's other such face and ends at an outer face,
/// and no cell comes twice, whatever the mesh's shape or rounding.
class CellWalk {
 public:
  /// Puts the walk at an outer face; false where the line does not meet it.
  bool enter(const VolumeView& view, const SightLine& line, std::uint32_t outer_face);
  /// Goes through a cell to its other face. False: that is an outer one, see outer_face().
  bool step(const VolumeView& view, const SightLine& line);

  /// Where the line meets the face that it is at.
  [[nodiscard]] double depth() const { return depth_; }
  [[nodiscard]] double level() const { return level_; }
  [[nodiscard]] std::uint32_t outer_face() const { return next_ - CellLinks::kOuter; }

 private:
  void place(const ViewVertex& vertex, const SightLine& line, std::size_t corner);
  void meet_face();

  // Of the face's corners; edges_[i] is u v' - u' v of the other two, >= 0.
  std::array<double, 3> u_{};
  std::array<double, 3> v_{};
  std::array<double, 3> depths_{};
  std::array<double, 3> levels_{};
  std::array<double, 3> edges_{};
  std::array<std::uint32_t, 3> corners_{};
  std::uint32_t next_ = 0;  ///< The cell that the line enters, or an outer face, see LinkedCell.
  double depth_ = 0;
  double level_ = 0;
};

}  // namespace lode
