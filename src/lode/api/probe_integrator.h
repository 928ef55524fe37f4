#pragma once

#include <array>

#include "lode/api/probe_cells.h"
#include "lode/api/probe_sums.h"
#include "lode/mappers/cell_part.h"

namespace lode::probe_sums {

/// A cell that is integrated over.
struct IntegralCell {
  std::array<Vec3d, 4> corners{};
  std::array<double, 4> values{};
  double error = 0;       ///< As the cell states it,
  bool is_exact = false;  ///< or none: F' is F there.
};

/// Adds up what cells, or what a box cuts out of them, have of an integral and its bounds.
class CellIntegrator {
 public:
  /// `cells`: what is proven of all cells. `deviation`: a bound of the volume between the
  /// boundaries of cells and of the reference. Both references must outlive it.
  CellIntegrator(const ProbeCells& cells, const IntegralOptions& options, double deviation)
      : cells_(cells), options_(options), deviation_(deviation) {}

  void add(const IntegralCell& cell, PartialIntegral& to) const;

 private:
  /// Of a cell's volume: what the reference folds over other cells counts less there, so that sums
  /// are those of cuts, where it is gone.
  [[nodiscard]] static double sign_of(const std::array<Vec3d, 4>& corners);
  [[nodiscard]] bool has_errors_everywhere(const IntegralCell& cell) const {
    return cell.is_exact || cells_.error_place == ErrorPlace::everywhere;
  }
  /// That F keeps on the cell's part in the box.
  [[nodiscard]] Range range_on(const std::array<Vec3d, 4>& corners) const;
  /// The box, a little larger or smaller than by what rounding may put a cell's cuts at it off
  /// by: 54 units of the cell's width (cell_part.cpp), and two of a plane's place.
  [[nodiscard]] Box3d moved_box(const std::array<Vec3d, 4>& corners, double sign) const;
  /// Of a cell on which F is within `error` of F'. What a smaller box cuts out is in the box, and
  /// what a larger one does holds all that is.
  void add_extremes_within(double error, const CellPart& part, const IntegralCell& cell,
                           Extremes& to) const;
  /// F is on some of the part, if that is more than can be outside of the reference.
  void add_extremes(const CellPart& part, const Range& range, Extremes& to) const;
  /// Whose values F has.
  void add_vertices(const IntegralCell& cell, Extremes& to) const;

  const ProbeCells& cells_;
  const IntegralOptions& options_;
  double deviation_;
};

/// What the sums say, of cells whose boundary may be off by that volume.
[[nodiscard]] IntegralReport to_report(const PartialIntegral& sum, const ProbeCells& cells,
                                       const std::optional<Box3d>& box, double deviation);

}  // namespace lode::probe_sums
