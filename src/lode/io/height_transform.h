#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "lode/core/height_frame.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"
#include "lode/io/point_file.h"
#include "lode/io/vertical_crs.h"

namespace lode::io {

/// Gives heights that were read the vertical CRS that the options declare, and transforms them to
/// their target; raster or points then have the unit and the CRS, compound or three-dimensional,
/// that fit. Transformed heights are float64.
///
/// Heights are transformed one by one where they are, all by one transformation: that of known
/// accuracy which PROJ names first and has the grids for. Fails where it has none, naming the grids
/// that better ones need, never taking a guess; on samples off the grid; and when cancelled.
[[nodiscard]] Result<VerticalOutcome> set_vertical(HeightRaster& raster,
                                                   const VerticalOptions& options,
                                                   Progress& progress);
[[nodiscard]] Result<VerticalOutcome> set_vertical(PointFile& file, const VerticalOptions& options,
                                                   Progress& progress);

/// Transforms rows of a raster that stays in its file. To be used by one thread at a time.
class RowTransformer {
 public:
  RowTransformer(RowTransformer&&) noexcept;
  RowTransformer& operator=(RowTransformer&&) noexcept;
  ~RowTransformer();

  /// Heights of whole rows; NaN, where one is missing, stays. Fails on samples off the grid, and
  /// when cancelled.
  [[nodiscard]] Result<void> transform(const HeightFrame& frame, std::int32_t first,
                                       std::int32_t n_rows, std::span<double> heights,
                                       Progress& progress) const;

 private:
  friend struct RowTransformerMaker;
  struct Impl;
  explicit RowTransformer(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

/// What is done to heights of a raster row by row as they are read.
struct VerticalPlan {
  VerticalOutcome outcome;
  std::optional<RowTransformer> rows{};  ///< Where there is a target.
};

/// As set_vertical(): gives the frame the CRS and the unit, and says how to get its heights.
[[nodiscard]] Result<VerticalPlan> plan_vertical(HeightFrame& frame, const VerticalOptions& options,
                                                 Progress& progress);

}  // namespace lode::io
