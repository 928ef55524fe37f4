#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/api/terrain_lines.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/delaunay_selector/selector.h"

namespace lode {

/// A terrain as points, its surface through all of them, and how much coarser the lattice of the
/// surface is.
struct LineGround {
  PointTerrain terrain;
  delaunay::Tin surface;  ///< With heights and twins.
  std::int32_t scale = 1;
  double step = 1;  ///< Columns and rows of the surface that draped lines are looked at in.
  double pull = 0;  ///< See LayingOptions.
};

/// What lines are to be made of a terrain's points.
struct FixedLines {
  using Edge = std::array<std::uint32_t, 2>;  ///< Numbers of points.

  std::vector<Edge> edges;
  std::vector<bool> is_own;  ///< By edge: points on it get its heights. Empty: none.
  std::vector<std::uint32_t> single;
};

/// In rows.
[[nodiscard]] inline bool is_before_in_rows(LatticePoint a, LatticePoint b) {
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

/// Lays breaklines onto the surface, and joins them with the lines that there are: points and their
/// numbers change. Fails as lay_lines() and node_lines() do.
[[nodiscard]] Result<void> add_breaklines(LineGround& ground, const TerrainLineOptions& options,
                                          FixedLines& fixed, TerrainLineReport& report,
                                          Progress& progress);

/// Gives points on breaklines with heights of their own those.
void put_points_on_lines(const delaunay_selector::LinedDomain& lined, const FixedLines& fixed,
                         HeightPoints& points, TerrainLineReport& report);

}  // namespace lode
