#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lode/models/diamond/selection.h"
#include "lode/models/diamond/sign_rows.h"

namespace lode::diamond {

/// One bit per sample of a volume: whether it is at least the isovalue. Of each slice the words of
/// 32 bits along x, x lowest, and of each of these all rows, y after y: so rows beside each other
/// are looked at together. Bits beyond the data, and the last word, are 0. Determined are the
/// samples of boxes that the surface may meet, and of those beside them that their edges end in.
struct SignField {
  /// Rows that are looked at together.
  static constexpr std::size_t kRows = 8;
  static constexpr std::int32_t kLayer = Model<3>::kLayer;

  Index<3> dims;
  std::size_t stride = 0;      ///< Words along x, with the last one.
  std::size_t row_stride = 0;  ///< Rows, with padding: kRows more can be read behind any.
  std::unique_ptr<std::uint32_t[]> words;

  /// Boxes of a brick's samples in kLayer slices, and of the samples behind these that edges end
  /// at.
  Index<3> box_dims;
  /// By row of boxes, y first, those that the surface may meet, as words: a row's last sample,
  /// where it is in a word of its own, is the last box's.
  std::vector<std::vector<std::uint32_t>> met;

  void resize(const Index<3>& samples) {
    dims = samples;
    stride = (as_size(dims[0]) + 31) / 32 + 1;
    row_stride = (as_size(dims[1]) / kRows + 2) * kRows;
    words = std::make_unique_for_overwrite<std::uint32_t[]>(row_stride * stride * as_size(dims[2]));
  }
  /// Words that edges from anchors in this row may be crossed in. No edge of a box leaves it.
  [[nodiscard]] std::span<const std::uint32_t> met_words(std::int32_t y, std::int32_t z) const {
    const std::size_t box_y = as_size(std::min(y / kBrickEdge<3>, box_dims[1] - 1));
    const std::size_t box_z = as_size(std::min(z / kLayer, box_dims[2] - 1));
    return met[box_z * as_size(box_dims[1]) + box_y];
  }
  [[nodiscard]] std::size_t n_words() const { return stride - 1; }
  [[nodiscard]] std::size_t offset(std::size_t word, std::int32_t y, std::int32_t z) const {
    return (as_size(z) * stride + word) * row_stride + as_size(y);
  }
  /// Of a row's word the bits that are samples, and those where a cell begins.
  [[nodiscard]] std::uint32_t sample_bits(std::size_t word) const {
    return first_bits(dims[0] - 32 * static_cast<std::int64_t>(word));
  }
  [[nodiscard]] std::uint32_t cell_bits(std::size_t word) const {
    return first_bits(dims[0] - 1 - 32 * static_cast<std::int64_t>(word));
  }
  /// The first n of 32.
  [[nodiscard]] static std::uint32_t first_bits(std::int64_t n) {
    if (n >= 32) return ~std::uint32_t{0};
    return n <= 0 ? 0 : (std::uint32_t{1} << n) - 1;
  }
};

/// The slices of a volume, some at a time: as boxes, slabs share the samples between them, and the
/// last one has those at its end too. None of them is in two layers of boxes.
class Slabs {
 public:
  /// As many slices as most are of: most samples are looked at in two, and those of a few slabs
  /// stay in the caches.
  static constexpr std::int32_t kUsualEdge = SignField::kLayer;

  /// `edge`: a power of two, at most that.
  Slabs(std::int32_t n_slices, std::int32_t edge)
      : n_slices_(n_slices), edge_(edge), n_(as_size(std::max(1, (n_slices + edge - 2) / edge))) {}

  [[nodiscard]] std::size_t n() const { return n_; }
  [[nodiscard]] std::int32_t begin(std::size_t slab) const {
    return static_cast<std::int32_t>(slab) * edge_;
  }
  [[nodiscard]] std::int32_t end(std::size_t slab) const {
    return slab + 1 == n_ ? n_slices_ : begin(slab + 1);
  }

 private:
  std::int32_t n_slices_;
  std::int32_t edge_;
  std::size_t n_;
};

/// Finds the signs of a model without holes, slices by slices. Boxes whose range misses the
/// isovalue are not read.
class SignFinder {
 public:
  /// Sizes the field. Both must stay as they are and where they are.
  SignFinder(const Selection<3>& selection, SignField& field);

  /// Slices [begin, end), none of them in two layers of boxes. Others may be found meanwhile.
  void find(std::int32_t begin, std::int32_t end);
  /// Bricks that the surface may meet.
  [[nodiscard]] std::uint64_t n_met() const;

 private:
  enum class State : std::uint8_t { outside, inside, met };
  /// Samples from `lower` on, n[i] of them along axis i.
  struct SampleBox {
    Index<3> lower;
    Index<3> n;
  };

  [[nodiscard]] std::size_t n_x() const { return as_size(field_.box_dims[0]); }
  [[nodiscard]] std::size_t brick_of(std::size_t box) const;
  [[nodiscard]] State state_of(std::size_t box) const;
  void look_at(std::size_t row);
  [[nodiscard]] bool is_wanted(const Index<3>& box) const;
  void find_box(const Index<3>& box, std::int32_t begin, std::int32_t end);
  void fill(const SampleBox& samples, std::size_t word, std::uint32_t bits);
  void read(std::size_t box, const SampleBox& samples);

  const Model<3>& model_;
  const double isovalue_;
  SignField& field_;
  std::vector<State> states_;  ///< By box.
};

/// All signs; `n_bricks_read` counts the bricks that the surface may meet.
[[nodiscard]] SignField sign_field(const Selection<3>& selection, Threads threads,
                                   std::uint64_t& n_bricks_read);

}  // namespace lode::diamond
