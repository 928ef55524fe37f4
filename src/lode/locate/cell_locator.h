#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/vec.h"

namespace lode {

/// A point as seen by a tetrahedron: what of each corner makes it up. All are 0 or more in it.
struct CellWeights {
  std::array<double, 4> weights{};
  /// By how much each may be off because of rounding; infinite where the cell is flat.
  double rounding = 0;

  [[nodiscard]] double least() const;
  /// Those of a point of the cell: that itself, or one near where the point is outside.
  [[nodiscard]] std::array<double, 4> clamped() const;
};

/// A cell, and how far its faces are from a point.
struct NearestCell {
  std::uint32_t cell;
  double distance;
};

/// Finds the tetrahedra that hold a point, or are near it, whatever their sizes and shapes: a tree
/// of boxes over cells along a curve in space. Cells may overlap, be flat or turned round. Const
/// members are safe from many threads. O(n log n) to make, 70 bytes a cell.
class CellLocator {
 public:
  using Cell = std::array<std::uint32_t, 4>;

  /// `positions` are finite; they and the cells, fewer than 2^32, must outlive it.
  CellLocator(std::span<const Vec3d> positions, std::span<const Cell> cells, Threads threads);

  /// Calls visit(number) for each cell whose box is within `reach` of p along each axis: always in
  /// the same order.
  template <typename Visit>
  void visit_near(const Vec3d& p, double reach, const Visit& visit) const;
  /// The same for each cell whose box, and those that hold it, meets(box) says true of.
  template <typename Meets, typename Visit>
  void visit_where(const Meets& meets, const Visit& visit) const;
  [[nodiscard]] std::array<Vec3d, 4> corners_of(std::uint32_t cell) const;
  [[nodiscard]] CellWeights weights_in(std::uint32_t cell, const Vec3d& p) const;
  /// The distance from p to the cell's faces: 0 where it is on one, also where it is inside.
  [[nodiscard]] double distance_to_faces(std::uint32_t cell, const Vec3d& p) const;
  /// The smallest distance_to_faces(); infinite where there are no cells.
  [[nodiscard]] double distance_to_nearest(const Vec3d& p) const;
  /// The cell that has it, if that is at most `limit`; of several always the same.
  [[nodiscard]] std::optional<NearestCell> nearest_within(const Vec3d& p, double limit) const;
  /// The point of a cell's faces that is nearest to p, to rounding.
  [[nodiscard]] Vec3d nearest_on_faces(std::uint32_t cell, const Vec3d& p) const;

 private:
  static constexpr std::size_t kBranches = 4;

  [[nodiscard]] Box3d box_of(const Cell& cell) const;
  void sort_cells(Threads threads);
  void join_boxes(Threads threads);

  std::span<const Vec3d> positions_;
  std::span<const Cell> cells_;
  std::vector<std::uint32_t> order_;        ///< Numbers of cells, along the curve.
  std::vector<std::vector<Box3d>> levels_;  ///< Those of cells first; then each of up to four.
};

template <typename Visit>
void CellLocator::visit_near(const Vec3d& p, double reach, const Visit& visit) const {
  const auto is_near = [&](const Box3d& box) {
    bool is = true;
    for (std::size_t i = 0; i < 3; ++i)
      is = is && box.lower[i] - reach <= p[i] && p[i] <= box.upper[i] + reach;
    return is;
  };
  visit_where(is_near, visit);
}

template <typename Meets, typename Visit>
void CellLocator::visit_where(const Meets& meets, const Visit& visit) const {
  struct Place {
    std::size_t level;
    std::size_t at;
  };
  // At each level of at most 17 all four branches of one place wait.
  std::array<Place, 80> open;
  std::size_t n = 0;
  if (!order_.empty()) open[n++] = {levels_.size() - 1, 0};
  while (n > 0) {
    const Place place = open[--n];
    if (!meets(levels_[place.level][place.at])) continue;
    if (place.level == 0) {
      visit(order_[place.at]);
      continue;
    }
    const std::size_t n_below = levels_[place.level - 1].size();
    for (std::size_t k = 0; k < kBranches && place.at * kBranches + k < n_below; ++k)
      open[n++] = {place.level - 1, place.at * kBranches + k};
  }
}

}  // namespace lode
