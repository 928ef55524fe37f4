#pragma once

#include <optional>
#include <vector>

#include "lode/core/horizontal_metric.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/refine/demand.h"

namespace lode {

/// A rectangle in the world.
struct PlaceBox {
  Vec<double, 2> lower;
  Vec<double, 2> upper;
};

/// Where the tolerance of a TIN holds. Of several kinds each asks for what it asks, and the finest
/// counts.
struct TerrainFocus {
  std::vector<PlaceBox> boxes;  ///< The tolerance where a triangle's bounding box meets one.
  std::optional<Vec<double, 2>> point{};  ///< The tolerance there, and `growth` more of it with
  double growth = 0;                      ///< each unit of distance, as the metric has it; >= 0.
  HorizontalMetric metric{};
  std::optional<double> max_error_outside{};  ///< Elsewhere; unset: anything.

  [[nodiscard]] bool is_empty() const { return boxes.empty() && !point; }
};

/// Of a tolerance, in units of the heights. Distances are those to the nearest place of a
/// triangle's box, nearest by coordinates. Fails on what has no answer.
[[nodiscard]] Result<Demand> to_demand(const TerrainFocus& focus, double tolerance);

}  // namespace lode
