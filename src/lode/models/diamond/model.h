#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/uninitialized_array.h"
#include "lode/core/volume.h"
#include "lode/models/diamond/lattice_field.h"
#include "lode/models/diamond/world_code.h"

namespace lode::diamond {

/// Cells per edge of a brick, the unit in which samples lie in memory: a cube of the hierarchy.
template <int D>
inline constexpr std::int32_t kBrickEdge = D == 3 ? 32 : 128;
/// Samples per edge of a brick: bricks share their border samples.
template <int D>
inline constexpr std::int32_t kBrickSamples = kBrickEdge<D> + 1;
/// Level of the tier-0 diamond that is a whole brick.
template <int D>
inline constexpr int kBrickLevel = D == 3 ? 4 : 6;
template <int D>
inline constexpr std::size_t kBrickSize =
    D == 3 ? std::size_t{33} * 33 * 33 : std::size_t{129} * 129;
/// Longest axis, in samples: doubled lattice coordinates must fit in 21 bits.
inline constexpr std::int32_t kMaxSamplesPerAxis = (1 << 19) + 1;

/// Bricks per axis of a field's samples, >= 1.
template <int D>
[[nodiscard]] Index<D> brick_counts(const Shape<D>& shape) {
  Index<D> n;
  for (std::size_t i = 0; i < as_size(D); ++i)
    n[i] = std::max(1, (shape.dims[i] + kBrickEdge<D> - 2) / kBrickEdge<D>);
  return n;
}

/// The nested attributes of one level's nodes, on the level's grid (Shape::grid_dims); for level
/// 0 only of its tier-0 nodes, one per cube of side 2. Entries that are no node of the level are
/// unused.
struct NodeLevel {
  UninitializedArray<ErrorCode> error;  ///< Nested error, rounded up.
  UninitializedArray<float> low;  ///< Nested minimum above Model::range_reference(), rounded down.
  UninitializedArray<float>
      high;  ///< Nested maximum, likewise, rounded up; < low: no finite sample.
};

/// Of samples.
struct SampleRange {
  double low, high;
};

/// A volume's samples and the attributes of its diamond hierarchy, in memory.
template <int D>
struct Model : LatticeField<D, Model<D>> {
  using LatticeField<D, Model<D>>::sample_size;
  using LatticeField<D, Model<D>>::shape;
  using LatticeField<D, Model<D>>::storage;

  static constexpr std::int32_t kLayer = 8;
  static constexpr std::size_t kLayers = as_size(kBrickEdge<D> / kLayer);  ///< Of a brick.

  Index<D> brick_dims;                    ///< Bricks per axis, >= 1.
  UninitializedArray<std::byte> samples;  ///< Brick after brick, kBrickSize each, x fastest.
  std::vector<std::uint8_t> brick_holes;  ///< Per brick: 1 when one of its samples is a hole.
  /// Brick after brick, of kLayer slices at a time and the one behind them, as finish_samples()
  /// finds them: those of a node reach further. Empty in 2D, and where it has not. Nothing is said
  /// of bricks with holes.
  std::vector<SampleRange> layer_ranges;
  std::vector<NodeLevel> levels;  ///< Finest first; shape.n_levels of them.
  /// World errors of the same nodes; none where nobody has asked, and none of level 0 from files.
  WorldErrors worlds;
  std::vector<std::array<std::size_t, as_size(D)>> strides;  ///< Of their arrays, by axis.

  /// An empty model of the right sizes. Axes longer than kMaxSamplesPerAxis must be refused first.
  [[nodiscard]] static Model make(const VolumeInfo& info);
  /// Makes it the empty model of another volume, in the memory it has where that is enough.
  void reset(const VolumeInfo& volume);

  [[nodiscard]] std::size_t n_bricks() const { return n_points<D>(brick_dims); }
  [[nodiscard]] const std::byte* brick(std::size_t i) const {
    return samples.data() + i * kBrickSize<D> * sample_size();
  }
  [[nodiscard]] std::byte* brick(std::size_t i) {
    return samples.data() + i * kBrickSize<D> * sample_size();
  }
  [[nodiscard]] static std::size_t brick_offset(const Index<D>& local) {
    std::size_t offset = 0;
    for (std::size_t i = as_size(D); i-- > 0;)
      offset = offset * as_size(kBrickSamples<D>) + as_size(local[i]);
    return offset;
  }
  /// The sample at p; outside the data that of the nearest sample. Holes come as they are.
  [[nodiscard]] double value(Index<D> p) const {
    Index<D> b;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      p[i] = std::clamp(p[i], 0, shape.dims[i] - 1);
      b[i] = std::min(p[i] / kBrickEdge<D>, brick_dims[i] - 1);
      p[i] -= b[i] * kBrickEdge<D>;
    }
    const std::size_t offset = linear_index<D>(brick_dims, b) * kBrickSize<D> + brick_offset(p);
    return visit_storage_type(storage, [&]<typename T>() {
      T sample;
      std::memcpy(&sample, samples.data() + offset * sizeof(T), sizeof(T));
      return static_cast<double>(sample);
    });
  }
  /// Samples of a unit cell inside the data, as FieldSamples::find_corners() has them. Each cell
  /// lies in one brick.
  void find_corners(const Index<D>& even, const Index<D>& step,
                    std::array<double, std::size_t{1} << D>& values) const {
    Index<D> b;
    Index<D> local;
    std::array<std::ptrdiff_t, as_size(D)> along{};
    std::ptrdiff_t stride = 1;
    for (std::size_t i = 0; i < as_size(D); ++i, stride *= kBrickSamples<D>) {
      b[i] = std::min(std::min(even[i], even[i] + step[i]) / kBrickEdge<D>, brick_dims[i] - 1);
      local[i] = even[i] - b[i] * kBrickEdge<D>;
      along[i] = step[i] * stride;
    }
    const std::byte* const first = brick(linear_index<D>(brick_dims, b));
    visit_storage_type(storage, [&]<typename T>() {
      const T* const at = reinterpret_cast<const T*>(first) + brick_offset(local);
      for (std::size_t corner = 0; corner < values.size(); ++corner) {
        std::ptrdiff_t offset = 0;
        for (std::size_t i = 0; i < as_size(D); ++i)
          if ((corner >> i & 1) != 0) offset += along[i];
        values[corner] = static_cast<double>(at[offset]);
      }
    });
  }
  /// All but nodes of level 0 and tier >= 1 have stored attributes.
  [[nodiscard]] static bool has_attributes(const Diamond<D>& node) {
    return node.level > 0 || node.tier == 0;
  }
  /// Where a node's are in its level's arrays.
  [[nodiscard]] std::size_t attribute_index(const Diamond<D>& node) const {
    std::size_t index = 0;
    for (std::size_t i = 0; i < as_size(D); ++i)
      index += as_size(node.centre[i] >> std::max(node.level, 1)) * strides[as_size(node.level)][i];
    return index;
  }
  [[nodiscard]] StoredAttributes attributes(const Diamond<D>& node) const {
    const std::size_t at = attribute_index(node);
    const NodeLevel& level = levels[as_size(node.level)];
    return {level.error[at], level.low[at], level.high[at]};
  }
  /// Asks the memory for them.
  void prefetch(const Diamond<D>& node) const {
    const std::size_t at = attribute_index(node);
    const NodeLevel& level = levels[as_size(node.level)];
    __builtin_prefetch(&level.error[at]);
    __builtin_prefetch(&level.low[at]);
    __builtin_prefetch(&level.high[at]);
  }
  /// See NearSamples.
  template <typename Near>
  void find_near(Near& near, const Index<D>& centre, std::int32_t reach, int level) const {
    Index<D> b;
    Index<D> local;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      b[i] = centre[i] / kBrickEdge<D>;
      local[i] = centre[i] % kBrickEdge<D>;
      if (local[i] < reach << level || local[i] + (reach << level) > kBrickEdge<D>) return;
    }
    std::array<std::ptrdiff_t, as_size(D)> steps{};
    std::ptrdiff_t step = std::ptrdiff_t{1} << level;
    for (std::size_t i = 0; i < as_size(D); ++i, step *= kBrickSamples<D>) steps[i] = step;
    using T = std::remove_cvref_t<decltype(near.at(centre))>;
    const std::byte* const first = brick(linear_index<D>(brick_dims, b));
    near.found(reinterpret_cast<const T*>(first) + brick_offset(local), steps);
  }
  /// Whether a hole removes one of the unit cells along the domain's border.
  [[nodiscard]] bool has_removed_border_cell() const;
  /// Nested error of the unrefined base; 0 when there are no cells.
  [[nodiscard]] double base_error() const;
};

extern template struct Model<2>;
extern template struct Model<3>;

/// Converts n samples of `type` to its storage type.
void widen_samples(ScalarType type, const std::byte* from, std::size_t n, std::byte* to);

/// Copies a box of lattice samples (storage type, x fastest) into all bricks that hold them.
template <int D>
void put_samples(Model<D>& model, const LatticeBox<D>& box, const std::byte* values,
                 Threads threads);

/// Fills the parts of border bricks that lie beyond the data with the nearest samples.
template <int D>
void fill_beyond_data(Model<D>& model, Threads threads);

/// Completes a model whose samples have all been put: fills what is beyond the data, and finds
/// range, holes and removed cells.
template <int D>
void finish_samples(Model<D>& model, Threads threads);

/// Fails where samples are so large that F' could overflow: weights up to 2^19, and sums of
/// products.
[[nodiscard]] Result<void> check_magnitude(const FieldStats& stats);

/// Copies the samples of brick `b` with `margin` layers round them, clamped to the data, into
/// `out` ((kBrickSamples + 2·margin)^D values, x fastest), holes as NaN; V is float, double, or
/// Step (see SampleScale) where there are none. margin <= kBrickEdge.
template <int D, typename V>
void gather_values(const Model<D>& model, const Index<D>& b, std::int32_t margin, V* out);

/// What rounding may have hidden from a computed error: F' is a chain of at most 64 means or sums,
/// each rounded once. Nothing where all values are integers with room for the weights.
template <int D, typename Field>
[[nodiscard]] double rounding_slack(const LatticeField<D, Field>& field) {
  const bool is_exact = !is_floating(field.info.type) && size_of(field.info.type) <= 4;
  if (is_exact || field.stats.min == field.stats.max) return 0;
  return 0x1p-47 * std::max(std::abs(field.stats.min), std::abs(field.stats.max));
}

}  // namespace lode::diamond
