#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "lode/api/picture_frame.h"
#include "lode/api/query.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/refine/demand.h"

namespace lode {

/// How good a TIN is to be where a view shows it, whatever stands before it.
struct TerrainView {
  View view;  ///< Its camera is one of pictures of the terrain: see PictureFrame.
  std::optional<double> exaggeration{};  ///< Of that picture; unset: as picture_frame().
  std::optional<double> max_error_px{};  ///< Pixels, >= 0, of vertical errors in the picture.
  bool has_tolerance = false;            ///< The focus's tolerance, of heights, holds there, too.
};

struct TerrainViewReport {
  double exaggeration = 1;
  bool is_vertical_unit_known = false;   ///< Else it is assumed, as PictureFrame says.
  std::optional<double> max_error_px{};  ///< As asked for.
  bool has_tolerance = false;            ///< The same.
  /// Pixels that no vertical error at a sample takes where the view shows it; infinite where the
  /// camera stands in the bounds of a triangle that errs.
  double achieved_px = 0;
  std::uint64_t n_shown = 0;  ///< Triangles whose bounds reach into the view.

  [[nodiscard]] bool is_within_error() const {
    return !max_error_px || achieved_px <= *max_error_px;
  }
};

/// A view of a terrain, ready to be asked.
class TerrainViewFocus {
 public:
  /// Fails on cameras that show nothing, pictures without pixels, tolerances < 0, none at all, and
  /// as picture_frame() does.
  [[nodiscard]] static Result<TerrainViewFocus> make(const TerrainView& view,
                                                     const HeightFrame& grid,
                                                     const HeightRange& range,
                                                     const HorizontalMetric& metric);

  /// Whether some of it may be in the picture. `world`: x and y there, heights in their unit.
  [[nodiscard]] bool shows(const Bounds& world) const { return focus_.shows(frame_.place(world)); }
  /// A bound in pixels: of two points, one above the other by no more than `error`, both in the
  /// bounds and one of them in the picture, projections are no farther apart. Grows with both.
  [[nodiscard]] double pixels(double error, const Bounds& world) const;
  /// Positive where the view shows what errs by more than it or the tolerance allows.
  [[nodiscard]] Demand to_demand(double tolerance) const;
  /// Of a TIN with heights and errors.
  [[nodiscard]] TerrainViewReport measure(const delaunay::Tin& tin, const HeightFrame& grid) const;

 private:
  TerrainViewFocus(const TerrainView& view, const PictureFrame& frame, const HeightRange& range);

  TerrainView view_;
  PictureFrame frame_;
  HeightRange range_;  ///< Of all heights.
  ViewFocus focus_;
  Vec3d forward_;
  double pixels_per_slope_ = 0;  ///< A point at depth 1, beside the axis by 1, is so far from it.
  double spread_ = 0;            ///< How much a vertical step takes of that, at most.
  double sinking_ = 0;           ///< How much nearer to the camera's plane it comes, at most.
  double cos_corner_ = 1;        ///< Of the angle between the axis and the picture's corners.
};

}  // namespace lode
