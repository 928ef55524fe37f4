#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/api/terrain.h"
#include "lode/core/height_grid.h"
#include "lode/core/horizontal_metric.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/render/image.h"
#include "lode/render/surface_renderer.h"

namespace lode {

struct TerrainPictureOptions {
  /// Without max_error and max_cells: a quarter of a pixel, at the raster's longer side.
  TerrainOptions terrain;
  /// Pixels that no vertical error at a sample takes in the picture, >= 0: of models whose
  /// tolerances vary. What the picture does not show is as coarse as it may be; max_error, where it
  /// is given, holds in the picture, too.
  std::optional<double> max_error_px{};
  /// Heights count so many times, > 0. Unset: 1, or the largest of 1, 2, 5, 10, ... that makes the
  /// relief at most an eighth of the raster's longer side.
  std::optional<double> exaggeration{};
  std::optional<double> contour_interval{};  ///< Lines at its multiples, units of the heights; > 0.
  bool is_from_above = false;                ///< As a map, north up; else a three-quarter view.
  /// Without a colour: by height, land from green to white, what is below 0 in blues.
  RenderOptions render;
};

struct TerrainPictureReport {
  TerrainReport terrain;  ///< Without slacks of coordinates.
  double exaggeration = 1;
  bool is_vertical_unit_known = false;  ///< Else it is assumed, as PictureFrame says.
  double width = 0;  ///< Metres, of the raster: in the middle where these are of an ellipsoid.
  double depth = 0;
  std::uint64_t n_contours = 0;  ///< Lines.
  Camera camera;                 ///< That was used: metres from the raster's middle, x east.
  double seconds = 0;
};

/// Draws a TIN of the terrain in metres: longitudes and latitudes count as much
/// as they do in the raster's middle, heights as PictureFrame has them. Fails as
/// extract_terrain() and render_surface() do, and on more than 2^20 contour levels.
[[nodiscard]] Result<Image> draw_terrain(const Terrain& terrain, const HorizontalMetric& metric,
                                         const TerrainPictureOptions& options,
                                         TerrainPictureReport& report, Progress& progress);

}  // namespace lode
