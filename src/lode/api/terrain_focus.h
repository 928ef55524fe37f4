#pragma once

#include <optional>
#include <vector>

#include "lode/api/terrain_view.h"
#include "lode/core/height_frame.h"
#include "lode/core/horizontal_metric.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/refine/demand.h"

namespace lode {

inline constexpr const char* kFocusOrCells =
    "expected a focus or a number of triangles, got both: a focus says which tolerances hold "
    "where, and a number is met by one tolerance for all of the terrain";

/// A rectangle in the world.
struct PlaceBox {
  Vec<double, 2> lower;
  Vec<double, 2> upper;
};

/// How much of a box lies outside of a raster's pixels: from 0 to 1, of its area, or of its length
/// where it has none.
[[nodiscard]] double share_outside(const PlaceBox& box, const HeightFrame& frame);

/// Where the tolerance of a TIN holds. Of several kinds each asks for what it asks, and the finest
/// counts.
struct TerrainFocus {
  std::vector<PlaceBox> boxes;  ///< The tolerance where a triangle's bounding box meets one.
  std::optional<Vec<double, 2>> point{};  ///< The tolerance there, and `growth` more of it with
  double growth = 0;                      ///< each unit of distance, as the metric has it; >= 0.
  std::optional<TerrainView> view{};      ///< Where it shows them, what it says.
  HorizontalMetric metric{};              ///< Also of the view's picture.
  std::optional<double> max_error_outside{};  ///< Elsewhere; unset: anything.

  [[nodiscard]] bool has_place() const { return !boxes.empty() || point.has_value(); }
  [[nodiscard]] bool is_empty() const { return !has_place() && !view; }
};

/// A box whose longitudes are brought near to those of a terrain, by the whole turns that its
/// middle is away.
[[nodiscard]] PlaceBox near_terrain(const PlaceBox& box, const HorizontalMetric& metric,
                                    const HeightFrame& frame);

/// A focus on a terrain, ready to be asked.
class TerrainDemand {
 public:
  /// Of a tolerance, in units of the heights. Distances are those to the nearest place of a
  /// triangle's box, nearest by coordinates; longitudes a whole turn away are the same. Fails on
  /// what has no answer.
  [[nodiscard]] static Result<TerrainDemand> make(const TerrainFocus& focus, double tolerance,
                                                  const HeightFrame& grid,
                                                  const HeightRange& range);

  [[nodiscard]] const Demand& demand() const { return demand_; }
  /// Whether it has to do with the terrain at all, and does not lie beside it.
  [[nodiscard]] bool meets_terrain() const { return meets_terrain_; }
  /// What the focus's view shows of a TIN with heights and errors; nothing without a view.
  [[nodiscard]] std::optional<TerrainViewReport> measure(const delaunay::Tin& tin,
                                                         const HeightFrame& grid) const;

 private:
  Demand demand_;
  bool meets_terrain_ = true;
  std::optional<TerrainViewFocus> view_;
};

}  // namespace lode
