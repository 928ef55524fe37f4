#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "lode/api/probe.h"
#include "lode/core/mesh.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/refine/model.h"

namespace lode {

/// Cells of a cut, and what is proven of F on each: what probing starts from, whatever the model.
struct ProbeCells {
  /// Tetrahedra; of the cut those near what is probed at least.
  SimplexMesh mesh{};
  /// Whether F' is F at all its vertices; else at those of exact cells only.
  bool is_exact_at_vertices = true;
  ErrorPlace error_place = ErrorPlace::everywhere;
  /// By cell: whether F' is F on it; empty: where its error is 0.
  std::vector<std::uint8_t> is_exact{};
  /// A range that F is proven to keep on what cells that are not exact have in a box; there may be
  /// none where errors hold everywhere.
  std::function<Range(const Box3d&)> range_in{};
  /// The same; empty where all that F has in a box is on exact cells, or it has nothing there.
  std::function<Range(const Box3d&)> range_off_cells{};
  /// Of F anywhere, and the box of where it is.
  Range all{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Box3d domain{};
  /// By how much boundaries of cells that are not exact may be off, with what rounds their
  /// vertices and distances from them.
  double boundary_deviation = 0;
  double rounding = 0;  ///< Of distances from cells.
  double snap = 0;      ///< Points that are outside by no more than this are inside.

  [[nodiscard]] bool has_exact(std::size_t cell) const {
    return is_exact.empty() ? mesh.errors[cell] == 0 : is_exact[cell] != 0;
  }
};

[[nodiscard]] std::vector<ProbedPoint> probe_points_in(const ProbeCells& cells,
                                                       std::span<const Vec3d> points,
                                                       Threads threads);
/// Where the line meets faces.
[[nodiscard]] std::vector<ProbedLinePoint> probe_line_in(const ProbeCells& cells,
                                                         const Vec3d& begin, const Vec3d& end,
                                                         Threads threads);
/// `n` points of the line, 2 at least, at equal distances.
[[nodiscard]] std::vector<Vec3d> points_on(const ProbedLine& line);
/// The parts of those that are on a line.
[[nodiscard]] std::vector<ProbedLinePoint> on_line(const ProbedLine& line,
                                                   std::span<const ProbedPoint> points);
/// Counts points that are in no cell.
void count_outside(std::span<const ProbedPoint> points, ProbeReport& report);
/// Of all cells; the same for any number of threads.
[[nodiscard]] IntegralReport integrate_cells(const ProbeCells& cells,
                                             const IntegralOptions& options);

/// Refuses points that are not finite, and tolerances that are none.
[[nodiscard]] Result<void> check_probe(std::span<const Vec3d> points, double max_error);
[[nodiscard]] Result<void> check_snap(double snap);
[[nodiscard]] Result<void> check_line(const ProbedLine& line);
[[nodiscard]] Result<void> check_integral(const IntegralOptions& options);

}  // namespace lode
