#pragma once

#include <cstdint>
#include <optional>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/delaunay_selector/point_domain.h"

namespace lode::delaunay_selector {

using delaunay::InsertionOrder;

struct SelectorOptions {
  double max_error = 0;                      ///< Vertical, units of the heights; finite, >= 0.
  std::optional<std::uint64_t> max_cells{};  ///< At most so many triangles; strict order only.
  InsertionOrder order = InsertionOrder::levels;
  delaunay::TinLinks links = delaunay::TinLinks::left_out;
  Threads threads{};  ///< Of rasters in levels or tiles; the TIN is the same for any number.
};

struct Selection {
  delaunay::Tin tin;             ///< With heights.
  double achieved_error = 0;     ///< |z - z'| is at most this at every sample; rounded up.
  bool is_within_error = true;   ///< Else max_cells ended it.
  bool is_within_cells = true;   ///< Else the outline alone has more triangles.
  std::uint64_t n_samples = 0;   ///< In the domain.
  std::uint64_t n_left_out = 0;  ///< Valid samples that are not.
};

/// The Delaunay selector (L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for
/// topographic surface description", The Visual Computer 12, 1996, section 3 and figure 3): samples
/// are inserted into a Delaunay triangulation until the vertical error is within max_error at every
/// sample, or max_cells is reached. The domain is the union of the cells with four valid corners;
/// its outline is kept exactly, and constrains the triangulation where it is not convex; in tiles
/// seams do so, too. Where a raster is_round, its first and its last column have the same vertices,
/// but with max_cells. Time O(n log n) in the samples usually. Fails where there is no such cell,
/// and on heights beyond 1e30.
[[nodiscard]] Result<Selection> select_samples(const HeightGrid& grid,
                                               const SelectorOptions& options, Progress& progress);

/// The same of scattered points, in their domain. Fails in tiles.
[[nodiscard]] Result<Selection> select_points(const HeightPoints& points, const PointDomain& domain,
                                              const SelectorOptions& options, Progress& progress);

/// All samples: what a tolerance of 0 allows, without looking for those that are in the plane of
/// others. With links. O(samples). Fails where there is no cell with four valid corners, and on
/// heights beyond 1e30.
[[nodiscard]] Result<Selection> select_all_samples(const HeightGrid& grid);

/// The same of scattered points; where they lie on one circle as insertion in a shuffled order has
/// it. O(n log n) expected.
[[nodiscard]] Result<Selection> select_all_points(const HeightPoints& points,
                                                  const PointDomain& domain, Progress& progress);

}  // namespace lode::delaunay_selector
