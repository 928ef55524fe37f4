#pragma once

#include <cstdint>
#include <span>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/surface.h"
#include "lode/delaunay/lattice.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// What a surface is as a TIN of a grid's samples. Counts of faults are 0 where all is well; what
/// needs earlier checks to have passed is left out after the first that fails.
struct TinFacts {
  std::uint64_t n_vertices = 0;
  std::uint64_t n_off_samples = 0;  ///< Not at a sample of the domain, or of another height.
  double height_offset = 0;         ///< Largest, of those at samples: rounding in the file.
  std::uint64_t n_triangles = 0;
  std::uint64_t n_turned = 0;  ///< Of no area, or facing down.
  std::uint64_t n_edges = 0;
  std::uint64_t n_overused = 0;  ///< Of more than two triangles, or of two on one side.
  std::uint64_t n_inner_edges = 0;
  std::uint64_t n_not_delaunay = 0;      ///< The vertex across lies inside the circle.
  std::uint64_t n_on_seams = 0;          ///< Of those, with TinSeams::none: as TinSeams::allowed.
  std::uint64_t n_constrained = 0;       ///< It does, too, but the edge is fixed or on a seam.
  std::uint64_t n_lines = 0;             ///< Edges that were to be fixed.
  std::uint64_t n_broken_lines = 0;      ///< Those that are not all edges of triangles.
  std::uint64_t n_cells = 0;             ///< Of the domain of a grid.
  std::int64_t doubled_domain_area = 0;  ///< In squares of nodes.
  std::int64_t doubled_area = 0;         ///< Of all triangles.
  std::uint64_t n_border_edges = 0;
  std::uint64_t n_off_outline = 0;  ///< Border edges that are not on the domain's outline.
  std::uint64_t n_samples = 0;      ///< Of the domain.
  std::uint64_t n_uncovered = 0;    ///< In no triangle.
  std::uint64_t n_beyond = 0;       ///< Farther than max_error from a triangle that they lie in.
  bool is_round = false;            ///< As the grid; then there are the next two.
  std::uint64_t n_side_rows = 0;    ///< With a vertex on the first or the last column.
  std::uint64_t n_unmatched = 0;    ///< Of those: on one alone, though the other has cells there.
  double worst_error = 0;           ///< |z - z'| of all samples in all triangles, heights exact.
  delaunay::LatticePoint worst{};   ///< Column and row of the first that has it.

  [[nodiscard]] bool is_covered() const {
    return doubled_area == doubled_domain_area && n_off_outline == 0 && n_uncovered == 0;
  }
};

/// Whether edges on columns and rows that no triangle crosses need not be Delaunay.
enum class TinSeams : std::uint8_t { none, allowed };

struct TinCheckOptions {
  double max_error = 0;
  TinSeams seams = TinSeams::none;
  Threads threads{};
  /// Of PlacedSurface: where a surface has its vertices, in place of its positions; empty: there.
  std::span<const Vec3d> places{};
};

/// Holds a surface against the samples it was made from, by other means than it was made: nodes of
/// bounding boxes by the signs of areas, circles by CGAL's exact predicates. Errors are computed in
/// 64 bits of mantissa, integers exactly. The same for any number of threads. Fails when cancelled.
[[nodiscard]] Result<TinFacts> check_tin(const Surface& surface, const HeightGrid& grid,
                                         const TinCheckOptions& options, Progress& progress);

/// The same of a TIN with heights that lies in the grid, whose columns and rows are `scale` nodes
/// of the TIN's lattice apart: its vertices are samples, or lie on a side of a cell between two,
/// with the height that is linear there, to within rounding. Rounded heights must be allowed for in
/// max_error.
[[nodiscard]] Result<TinFacts> check_fine_tin(const delaunay::Tin& tin, std::int32_t scale,
                                              const HeightGrid& grid, double max_error,
                                              Threads threads, Progress& progress);

}  // namespace lode
