#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>

#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_tin.h"
#include "lode/locate/tin_locator.h"

namespace lode {

struct TerrainTin::Impl {
  HeightFrame frame;
  HorizontalMetric metric;
  TerrainReport report;
  delaunay::Tin tin;
  mutable std::once_flag has_locator{};
  mutable std::unique_ptr<TinLocator> made_locator{};

  /// Made when first asked for.
  [[nodiscard]] const TinLocator& locator() const {
    std::call_once(has_locator, [this] { made_locator = std::make_unique<TinLocator>(tin); });
    return *made_locator;
  }
  /// Of a triangle's, kept as floats rounded up, none is above the whole's.
  [[nodiscard]] double error_bound(double error) const {
    return std::min(error, report.achieved_error);
  }
  [[nodiscard]] Place to_lattice(const Place& world) const {
    return frame.snapped_lattice(world[0], world[1]);
  }
};

}  // namespace lode
