#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"

namespace lode::triangle_hierarchy {

using delaunay::LatticePoint;

/// The heights of a raster as float64, and a lattice scale() = 2^bits() times as fine, whose nodes
/// are the vertices of triangles over it: samples, and nodes on a column or row between two of
/// them, where the height is linear between these. Fine coordinates have at most 30 bits.
class FineGrid {
 public:
  /// 8 bytes a sample. Fails as delaunay::find_domain() and check_heights() do.
  [[nodiscard]] static Result<FineGrid> make(const HeightGrid& grid);

  [[nodiscard]] const HeightFrame& frame() const { return frame_; }
  [[nodiscard]] int bits() const { return bits_; }
  [[nodiscard]] std::int32_t scale() const { return std::int32_t{1} << bits_; }
  [[nodiscard]] LatticePoint fine(LatticePoint sample) const {
    return {sample.x << bits_, sample.y << bits_};
  }
  [[nodiscard]] double sample(std::int32_t column, std::int32_t row) const {
    return samples_[static_cast<std::size_t>(std::int64_t{row} * frame_.n_columns + column)];
  }
  /// At a fine node of the domain on a column or row.
  [[nodiscard]] double height(LatticePoint fine) const;
  /// The coarsest triangulation of the domain, the union of the cells with four heights; fine
  /// nodes.
  [[nodiscard]] const std::vector<std::array<LatticePoint, 3>>& base() const { return base_; }
  /// Errors count as beyond a tolerance where they are by more than this, 2^-50 of the largest
  /// |height|, so that planes are not refined for rounding.
  [[nodiscard]] double slack() const { return slack_; }
  /// More than computed errors may be off: docs/models/hierarchical_triangulations.md.
  [[nodiscard]] double rounding() const { return 3 * slack_; }

 private:
  HeightFrame frame_;
  int bits_ = 0;
  double slack_ = 0;
  std::vector<double> samples_;  ///< 0 where there is none.
  std::vector<std::array<LatticePoint, 3>> base_;
};

}  // namespace lode::triangle_hierarchy
