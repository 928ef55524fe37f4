#pragma once

#include <cstdint>

#include "lode/models/terrain/right_triangle_bisection/bisection_lattice.h"

namespace lode::bisection {

/// Samples of a raster, as HeightGrid has them: from each on HeightGrid::kPadding more may be read.
template <typename T>
struct RasterRows {
  const T* samples = nullptr;
  std::int64_t stride = 0;

  [[nodiscard]] const T* row(std::int32_t y) const { return samples + y * stride; }
};

/// Rows of cells that are looked at together.
inline constexpr std::int32_t kStripRows = 16;

/// The **own error** of a node: the largest |z - z'| of the samples in its diamond, z' on its two
/// triangles, but for samples on the diamond's sides, which are on hypotenuses of its children.
///
/// Sets errors of all nodes on samples whose diamonds are within the raster, for the rows of cells
/// [y, y + kStripRows), y a multiple of kStripRows; those of other nodes get values that mean
/// nothing. But: errors of nodes whose column and row are multiples of kStripRows begin at 0, and
/// are raised; and what the other nodes in row y + kStripRows owe to this strip comes to `upper`,
/// of lattice.stride() elements, to be joined with what the next strip set, where there is one.
/// Strips may be done at the same time. Of integers exactly, but for rounding up to float32; of
/// others in float64, within 2^-46 of the largest |z|. The same on any instruction set.
template <typename T>
using AddStripErrors = void (*)(const RasterRows<T>& rows, const Lattice& lattice, std::int32_t y,
                                float* errors, float* upper);

/// The one for this processor; T is one of HeightGrid::Heights.
template <typename T>
[[nodiscard]] AddStripErrors<T> add_strip_errors();

}  // namespace lode::bisection
