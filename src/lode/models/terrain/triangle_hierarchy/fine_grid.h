#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode::triangle_hierarchy {

/// The heights of a raster as float64, linear along columns and rows. Vertices of triangles over it
/// are samples, and nodes of the finer lattice on a column or row between two of them.
class FineGrid final : public ReferenceSurface {
 public:
  /// 8 bytes a sample. Fails as delaunay::find_domain() and check_heights() do.
  [[nodiscard]] static Result<FineGrid> make(const HeightGrid& grid);

  [[nodiscard]] bool is_of_points() const override { return false; }
  [[nodiscard]] double sample(std::int32_t column, std::int32_t row) const {
    return samples_[static_cast<std::size_t>(std::int64_t{row} * frame().n_columns + column)];
  }
  /// At a fine node of the domain on a column or row.
  [[nodiscard]] double height(LatticePoint fine) const override;
  [[nodiscard]] EdgeSplit worst_crossing(Place a, Place b,
                                         Crossings crossings = Crossings::all) const override;
  [[nodiscard]] SampleErrors measure_samples(const std::array<Place, 3>& corners,
                                             EdgeSet open) const override;
  /// Nodes of columns and rows are everywhere.
  [[nodiscard]] bool has_samples_beside(const std::array<LatticePoint, 3>& /*corners*/,
                                        std::int32_t /*reach*/) const override {
    return true;
  }
  [[nodiscard]] std::size_t count_samples(
      const std::array<LatticePoint, 3>& corners) const override;

 private:
  std::vector<double> samples_;  ///< 0 where there is none.
};

}  // namespace lode::triangle_hierarchy
