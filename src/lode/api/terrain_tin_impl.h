#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_source.h"
#include "lode/api/terrain_tin.h"
#include "lode/locate/tin_locator.h"
#include "lode/locate/tin_neighbours.h"
#include "lode/locate/tin_profile.h"

namespace lode {

/// Finds triangles of a TIN, which outlives it; of one without triangles none.
class PlaceFinder {
 public:
  explicit PlaceFinder(const delaunay::Tin& tin) {
    if (!tin.triangles.empty()) locator_.emplace(tin);
  }
  [[nodiscard]] std::optional<std::uint32_t> find(const delaunay::Point& at) const {
    return locator_ ? locator_->find(at) : std::nullopt;
  }
  [[nodiscard]] std::vector<std::uint32_t> find_all(const delaunay::Point& at) const {
    return locator_ ? locator_->find_all(at) : std::vector<std::uint32_t>();
  }

 private:
  std::optional<TinLocator> locator_;
};

struct TerrainTin::Impl {
  HeightFrame frame;
  HorizontalMetric metric;
  TerrainReport report;
  delaunay::Tin tin;
  std::shared_ptr<const TerrainParts> parts{};  ///< In the TIN's place, where there are.
  /// The same of a model whose surfaces do not meet.
  std::shared_ptr<const TerrainPatches> patches{};
  /// Of the vertices, where there are parts to trace lines on.
  std::optional<HeightRange> range{};
  /// Of what parts and patches are.
  std::optional<Terrain> terrain{};
  TerrainOptions options{};
  delaunay::LatticePoint lower{};  ///< Of all vertices.
  delaunay::LatticePoint upper{};
  mutable std::once_flag has_finder{};
  mutable std::unique_ptr<PlaceFinder> made_finder{};
  mutable std::once_flag has_neighbours{};
  mutable std::unique_ptr<TinNeighbours> made_neighbours{};
  mutable std::once_flag has_period{};
  mutable std::int32_t made_period = 0;

  /// Made when first asked for. Of the TIN.
  [[nodiscard]] const PlaceFinder& finder() const {
    std::call_once(has_finder, [this] { made_finder = std::make_unique<PlaceFinder>(tin); });
    return *made_finder;
  }
  /// The same of what lies beside its triangles.
  [[nodiscard]] const TinNeighbours& neighbours() const;
  /// The column that is column 0 again, where the terrain goes round the earth to it and has its
  /// heights there, within the error of both; else 0.
  [[nodiscard]] std::int32_t period() const;
  /// The mesh's parts, where it has some, and what that use takes of them.
  [[nodiscard]] Result<void> find_parts(const Terrain& asked, const TerrainOptions& wanted,
                                        TinUse use, Progress& progress);
  /// The TIN, or its triangles that have one of some heights, and others.
  [[nodiscard]] Result<std::shared_ptr<const delaunay::Tin>> tin_crossing(
      std::span<const double> heights, Progress& progress) const;
  /// Finds the rectangle of the TIN.
  void find_rectangle();
  [[nodiscard]] bool is_in_rectangle(const delaunay::Point& at) const {
    return at[0] >= lower.x && at[0] <= upper.x && at[1] >= lower.y && at[1] <= upper.y;
  }
  /// What tin_profile() of the whole TIN is.
  [[nodiscard]] Result<std::vector<ProfilePoint>> profile(const Place& a, const Place& b,
                                                          Progress& progress) const;
  /// Of a triangle's, kept as floats rounded up, none is above the whole's. Of patches there may be
  /// more between points of a profile, as they bend.
  [[nodiscard]] double error_bound(double error) const {
    return patches ? error : std::min(error, report.achieved_error);
  }
  /// That a distance to a place is none.
  [[nodiscard]] static Error not_measured(const Place& at);
  [[nodiscard]] Place to_lattice(const Place& world) const {
    return frame.snapped_lattice(world[0], world[1]);
  }
  /// The same: of the longitudes that are one the first in the raster.
  [[nodiscard]] Place find_place(const Place& world) const;
  /// Of a column and row that no triangle holds.
  [[nodiscard]] TerrainHeight::Where where_off(const Place& at) const;
};

}  // namespace lode
