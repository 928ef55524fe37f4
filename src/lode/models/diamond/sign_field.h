#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// One bit per sample of a volume: whether it is at least the isovalue. Row (y, z) is `stride`
/// words of 32 bits, x lowest; bits beyond the data, and the last word, are 0. Determined are the
/// rows that edges of bricks end in which the surface may meet, and all others of those rows of
/// bricks.
struct SignField {
  /// How many words more can be read behind the last one, and behind the masks.
  static constexpr std::size_t kPadding = 16;

  Index<3> dims;
  std::size_t stride = 0;
  std::unique_ptr<std::uint32_t[]> words;
  std::vector<std::uint32_t> sample_bits;  ///< Of each word of a row: the bits that are samples,
  std::vector<std::uint32_t> cell_bits;    ///< and those where a cell begins.

  Index<3> brick_dims;
  std::vector<std::uint8_t> is_met;  ///< By row of bricks, y first: whether one's range meets it.

  /// Whether edges from anchors in this row can be crossed. No edge of a brick leaves it, as bricks
  /// share the samples between them.
  [[nodiscard]] bool may_cross(std::int32_t y, std::int32_t z) const {
    const std::size_t brick_y = as_size(std::min(y / kBrickEdge<3>, brick_dims[1] - 1));
    const std::size_t brick_z = as_size(std::min(z / kBrickEdge<3>, brick_dims[2] - 1));
    return is_met[brick_z * as_size(brick_dims[1]) + brick_y] != 0;
  }
  [[nodiscard]] std::size_t n_words() const { return stride - 1; }
  [[nodiscard]] std::size_t offset(std::int32_t y, std::int32_t z) const {
    return (as_size(z) * as_size(dims[1]) + as_size(y)) * stride;
  }
};

/// The signs of a model without holes. Bricks whose stored range misses the isovalue are not
/// read, and of others only the eighths whose range does not; `n_bricks_read` counts these others.
[[nodiscard]] SignField sign_field(const Selection<3>& selection, Threads threads,
                                   std::uint64_t& n_bricks_read);

}  // namespace lode::diamond
