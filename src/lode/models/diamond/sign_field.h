#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "lode/models/diamond/selection.h"
#include "lode/models/diamond/sign_rows.h"

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

/// The slices of a volume, some at a time: as bricks, slabs share the samples between them, and the
/// last one has those at its end too. None of them is in two layers of bricks.
class Slabs {
 public:
  /// As many slices as most are of: most samples are looked at in two, and those of a few slabs
  /// stay in the caches.
  static constexpr std::int32_t kUsualEdge = 8;

  /// `edge`: a power of two, at most a brick's.
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

/// Finds the signs of a model without holes, slices by slices. Bricks whose stored range misses the
/// isovalue are not read, and of others only the eighths whose range does not.
class SignFinder {
 public:
  /// Sizes the field. Both must stay as they are and where they are.
  SignFinder(const Selection<3>& selection, SignField& field);

  /// Slices [begin, end), none of them in two layers of bricks. Others may be found meanwhile.
  void find(std::int32_t begin, std::int32_t end);
  /// Bricks that the surface may meet.
  [[nodiscard]] std::uint64_t n_met() const;

 private:
  enum class State : std::uint8_t { outside, inside, met };
  /// Samples from `lower` on, n[i] of them along axis i: those of a brick, or of a part of one.
  struct SampleBox {
    Index<3> lower;
    Index<3> n;
  };

  [[nodiscard]] std::size_t n_x() const { return as_size(model_.brick_dims[0]); }
  void look_at(std::size_t row);
  [[nodiscard]] bool is_wanted(std::size_t row) const;
  [[nodiscard]] SampleBox samples_of(const Index<3>& brick) const;
  [[nodiscard]] std::optional<bool> uniform_sign(const Index<3>& lower, int level) const;
  void find_row(std::size_t row, std::int32_t begin, std::int32_t end);
  void clear(const SampleBox& first);
  void fill(const SampleBox& box, std::uint32_t wanted);
  void read(const Index<3>& brick, const SampleBox& box);
  void read_part(const Index<3>& brick, const SampleBox& part, const Index<3>& eighth);
  void read_samples(const Index<3>& brick, const SampleBox& part, SignPart wanted);
  [[nodiscard]] std::uint32_t* words_at(const Index<3>& p) const;

  const Selection<3>& selection_;
  const Model<3>& model_;
  SignField& field_;
  int level_;                  ///< Whose cubes are the bricks, or a coarsest one.
  std::vector<State> states_;  ///< By brick.
};

/// All signs; `n_bricks_read` counts the bricks that the surface may meet.
[[nodiscard]] SignField sign_field(const Selection<3>& selection, Threads threads,
                                   std::uint64_t& n_bricks_read);

}  // namespace lode::diamond
