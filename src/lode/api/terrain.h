#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/api/terrain_focus.h"
#include "lode/api/terrain_model.h"
#include "lode/api/terrain_source.h"
#include "lode/api/verify_report.h"
#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/surface.h"
#include "lode/delaunay/greedy_insertion.h"

namespace lode {

// The door's part of terrain: heights on a grid (read_heights in files.h) or at scattered points
// (point_terrain.h), and triangulations of them within a vertical error.
using delaunay::InsertionOrder;

struct TerrainOptions {
  /// Vertical, units of the heights, finite and >= 0; without: half a percent of their range, or
  /// with max_cells whatever comes of it.
  std::optional<double> max_error{};
  std::optional<std::uint64_t> max_cells{};  ///< At most so many triangles; orders strictly.
  InsertionOrder order = InsertionOrder::levels;
  Threads threads{};  ///< Of rasters in levels or tiles; the TIN is the same for any.
  std::optional<TerrainFocus> focus{};  ///< Where max_error holds; of models that can vary.
  /// It is of a raster that goes round the earth and ends with its first column (cut_open_at()):
  /// TerrainReport::n_one_sided is counted.
  bool is_closed = false;
  /// All heights of the raster that the terrain is of, where bounds are to hold everywhere: of a
  /// TIN that is asked (TerrainTin). Null: at samples.
  std::shared_ptr<const HeightGrid> samples{};
};

struct TerrainReport {
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  double max_error = 0;  ///< That was asked for, or chosen.
  /// A bound of |z - z'| at every sample of the domain: the largest one, rounded up, but of a
  /// right_triangle_bisection that of finer meshes where it is larger.
  double achieved_error = 0;
  /// That holds between samples, too: of the surface that full resolution has.
  bool is_everywhere = false;
  bool is_within_error = true;
  bool is_uniform = true;       ///< Else max_error holds in the focus alone.
  bool is_focus_empty = false;  ///< It lies beside the terrain.
  /// Samples that err by more than a focus asks where they are, of models whose triangles do not
  /// keep what the model does; and the largest of their errors.
  std::uint64_t n_beyond = 0;
  double worst_beyond = 0;
  std::optional<TerrainViewReport> view{};  ///< Of a focus that has one.
  bool budget_met = true;        ///< Else the domain's outline alone has more than max_cells.
  std::uint64_t n_samples = 0;   ///< Of the domain: corners of cells with four heights, or points.
  std::uint64_t n_missing = 0;   ///< Without a height; of rasters.
  std::uint64_t n_left_out = 0;  ///< With one, but not in the domain.
  double height_slack = 0;       ///< Rounding of heights in the surface's float coordinates.
  double position_slack = 0;     ///< Of positions, units of the world.
  std::uint64_t n_turned = 0;    ///< Triangles that rounding of positions turns over, or flattens.
  /// Of a TerrainSurface that is_closed: vertices on its first or last column that lie in an edge
  /// of the other one.
  std::uint64_t n_one_sided = 0;
  double seconds = 0;
};

/// What is left of a TIN by a rectangle of the world.
struct TerrainClip {
  PlaceBox box;
  std::uint64_t n_kept = 0;       ///< Triangles that meet it.
  std::uint64_t n_triangles = 0;  ///< Of the whole.
};

struct TerrainSurface {
  Surface surface;  ///< Triangles, facing up; values are the heights, exactly.
  /// Of PlacedSurface, where floats do not have all heights (TerrainReport::height_slack > 0).
  std::vector<Vec3d> places;
  TerrainReport report;  ///< Errors are those of the whole TIN; the rest of what is left.
  std::optional<TerrainClip> clip{};
};

/// The TIN of a terrain; of a raster that of the model delaunay_selector: see
/// docs/models/delaunay_selector.md. With a box only the triangles that meet it, whole. Fails where
/// no cell of the grid has four heights, where a box meets no triangle, and when cancelled.
[[nodiscard]] Result<TerrainSurface> extract_terrain(const Terrain& terrain,
                                                     const TerrainOptions& options,
                                                     Progress& progress,
                                                     const std::optional<PlaceBox>& clip = {});

/// What a TIN has to be beside true: of TinShape::delaunay all edges that are not on the outline
/// must be; of TinShape::tiles all but those on seams, which are columns and rows that no triangle
/// crosses.
enum class TinShape : std::uint8_t { delaunay, tiles, any };

[[nodiscard]] constexpr TinShape shape_of(TerrainModel model) {
  return model == TerrainModel::ternary_triangulation || is_on_squares(model) || is_hierarchy(model)
             ? TinShape::any
             : TinShape::delaunay;
}

struct TerrainVerifyOptions {
  double max_error = 0;
  TinShape shape = TinShape::delaunay;
  /// Of a grid that is_round: its sides must have the same vertices, as those of the
  /// delaunay_selector have.
  bool matches_sides = false;
  Threads threads{};
  /// Of PlacedSurface: where the surface has its vertices; empty: at its positions.
  std::span<const Vec3d> places{};
};

/// Checks that a surface is a TIN of the grid's samples of that shape, covers exactly the cells
/// with four heights, and that no sample is farther than max_error from it, by other means than it
/// was made.
[[nodiscard]] Result<VerifyReport> verify_terrain(const HeightGrid& grid, const Surface& surface,
                                                  const TerrainVerifyOptions& options,
                                                  Progress& progress);

struct TerrainInfo {
  std::uint64_t n_missing = 0;
  bool has_heights = false;
  double lower = 0;  ///< Of the heights, where there are any.
  double upper = 0;
  std::uint64_t n_cells = 0;     ///< With four heights.
  std::uint64_t n_left_out = 0;  ///< Samples with a height that are in none.
};

[[nodiscard]] TerrainInfo describe_terrain(const HeightGrid& grid);

}  // namespace lode
