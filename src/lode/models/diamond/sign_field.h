#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// One bit per sample of a volume: whether it is at least the isovalue. Row (y, z) is `stride`
/// words of 32 bits, x lowest; bits beyond the data, and the last word, are 0.
struct SignField {
  /// How many words more can be read behind the last one, and behind the masks.
  static constexpr std::size_t kPadding = 16;

  Index<3> dims;
  std::size_t stride = 0;
  std::vector<std::uint32_t> words;
  std::vector<std::uint32_t> sample_bits;  ///< Of each word of a row: the bits that are samples,
  std::vector<std::uint32_t> cell_bits;    ///< and those where a cell begins.

  [[nodiscard]] std::size_t n_words() const { return stride - 1; }
  [[nodiscard]] std::size_t offset(std::int32_t y, std::int32_t z) const {
    return (as_size(z) * as_size(dims[1]) + as_size(y)) * stride;
  }
};

/// The signs of a model without holes. Bricks whose stored range misses the isovalue are not
/// read; `n_bricks_read` counts the others.
[[nodiscard]] SignField sign_field(const Selection<3>& selection, Threads threads,
                                   std::uint64_t& n_bricks_read);

}  // namespace lode::diamond
