#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/uninitialized_array.h"
#include "lode/core/volume.h"
#include "lode/models/diamond/error_code.h"
#include "lode/models/diamond/lattice.h"
#include "lode/models/diamond/storage_type.h"

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

/// The nested attributes of one level's nodes, on the level's grid (Shape::grid_dims); for level
/// 0 only of its tier-0 nodes, one per cube of side 2. Entries that are no node of the level are
/// unused.
struct NodeLevel {
  UninitializedArray<ErrorCode> error;  ///< Nested error, rounded up.
  UninitializedArray<float> low;  ///< Nested minimum above Model::range_reference(), rounded down.
  UninitializedArray<float>
      high;  ///< Nested maximum, likewise, rounded up; < low: no finite sample.
};

/// Facts about the samples, found while they are read.
struct FieldStats {
  double min = 0;  ///< Of the samples that are no holes; both 0 when there is none.
  double max = 0;
  std::uint64_t n_holes = 0;
  std::uint64_t n_removed_cells = 0;  ///< Unit cells that touch a hole.
};

/// Which axes of the grid the lattice uses: all three for diamond3d; for diamond2d the two that
/// have more than one sample (or the first ones, where fewer have).
template <int D>
struct AxisMap {
  std::array<int, as_size(D)> axis{};

  [[nodiscard]] static AxisMap of(const Index3& dims) {
    AxisMap map;
    int n = 0;
    for (int i = 0; i < 3 && n < D; ++i)
      if (D == 3 || dims[as_size(i)] > 1) map.axis[as_size(n++)] = i;
    for (int i = 0; i < 3 && n < D; ++i)
      if (dims[as_size(i)] == 1) map.axis[as_size(n++)] = i;
    std::sort(map.axis.begin(), map.axis.end());
    return map;
  }
  [[nodiscard]] Index<D> lattice_dims(const Index3& dims) const {
    Index<D> result;
    for (std::size_t i = 0; i < as_size(D); ++i) result[i] = dims[as_size(axis[i])];
    return result;
  }
  template <typename S>
  [[nodiscard]] Vec<S, 3> to_grid(const Vec<S, as_size(D)>& p) const {
    Vec<S, 3> result;
    for (std::size_t i = 0; i < as_size(D); ++i) result[as_size(axis[i])] = p[i];
    return result;
  }
};

/// A volume's samples and the attributes of its diamond hierarchy, in memory.
template <int D>
struct Model {
  VolumeInfo info;
  ScalarType storage = ScalarType::uint8;  ///< How samples are held: storage_type(info.type).
  AxisMap<D> axes;
  Shape<D> shape;
  FieldStats stats;
  Index<D> brick_dims;                    ///< Bricks per axis, >= 1.
  UninitializedArray<std::byte> samples;  ///< Brick after brick, kBrickSize each, x fastest.
  std::vector<std::uint8_t> brick_holes;  ///< Per brick: 1 when one of its samples is a hole.
  std::vector<NodeLevel> levels;          ///< Finest first; shape.n_levels of them.

  /// An empty model of the right sizes. Axes longer than kMaxSamplesPerAxis must be refused first.
  [[nodiscard]] static Model make(const VolumeInfo& info);

  [[nodiscard]] std::size_t sample_size() const { return size_of(storage); }
  [[nodiscard]] std::size_t n_bricks() const { return n_points<D>(brick_dims); }
  [[nodiscard]] bool has_holes() const { return stats.n_holes > 0; }
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
  /// As value(), but NaN for a hole.
  [[nodiscard]] double value_or_nan(const Index<D>& p) const {
    const double sample = value(p);
    return has_holes() && is_hole(sample) ? std::numeric_limits<double>::quiet_NaN() : sample;
  }
  [[nodiscard]] Index<D> clamped(Index<D> p) const {
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = std::clamp(p[i], 0, shape.dims[i] - 1);
    return p;
  }
  [[nodiscard]] bool is_hole(double sample) const {
    return !std::isfinite(sample) || (info.nodata && sample == *info.nodata);
  }
  /// Whether the unit cell with this lowest corner touches a hole. Must lie in the data.
  [[nodiscard]] bool is_removed_cell(const Index<D>& cell) const {
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> p = cell;
      for (int i = 0; i < D; ++i) p[as_size(i)] += (corner >> i) & 1;
      if (is_hole(value(p))) return true;
    }
    return false;
  }
  /// Whether a hole removes one of the unit cells along the domain's border.
  [[nodiscard]] bool has_removed_border_cell() const;
  /// Whether some, but not all, of the unit cells round a point are removed by holes: simplices
  /// that meet there must be refined.
  [[nodiscard]] bool is_mixed(const Index<D>& p) const {
    bool has_present = false;
    bool has_removed = false;
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> cell = p;
      bool is_real = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        cell[i] -= (corner >> i) & 1;
        is_real = is_real && cell[i] >= 0 && cell[i] < shape.dims[i] - 1;
      }
      if (is_real) (is_removed_cell(cell) ? has_removed : has_present) = true;
    }
    return has_present && has_removed;
  }
  /// The lowest corner of a unit cell in the data that one of the simplex's finest ones lies in.
  [[nodiscard]] std::optional<Index<D>> cell_inside(const Simplex<D>& s) const {
    const LatticeBox<D> box = bounds_of(s);
    if (!shape.overlaps_data(box)) return {};
    if (is_finest(s)) return box.lower;
    for (const Simplex<D>& half : bisect(s))
      if (const auto cell = cell_inside(half)) return cell;
    return {};
  }
  /// Whether an unrefined simplex is removed by holes: as a whole or not at all, so that the
  /// first of its cells that is in the data tells.
  [[nodiscard]] bool is_removed(const Simplex<D>& s) const {
    const auto cell = cell_inside(s);
    return cell && is_removed_cell(*cell);
  }
  /// What ranges are stored relative to, so that float32 keeps them tight: the field's minimum,
  /// or 0 for integers of up to 16 bits, which float32 holds.
  [[nodiscard]] double range_reference() const { return sample_size() <= 2 ? 0.0 : stats.min; }
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

/// Completes a model whose samples have all been put: fills the parts of border bricks that lie
/// beyond the data with the nearest samples, and finds range, holes and removed cells.
template <int D>
void finish_samples(Model<D>& model, Threads threads);

/// Fails where samples are so large that F' could overflow: weights up to 2^19, and sums of
/// products.
[[nodiscard]] Result<void> check_magnitude(const FieldStats& stats);

/// Copies the samples of brick `b` with `margin` layers round them, clamped to the data, into
/// `out` ((kBrickSamples + 2·margin)^D values, x fastest), holes as NaN. margin <= kBrickEdge.
template <int D, typename C>
void gather_values(const Model<D>& model, const Index<D>& b, std::int32_t margin, C* out);

/// What rounding may have hidden from a computed error: F' is a chain of at most 64 means or sums,
/// each rounded once. Nothing where all values are integers with room for the weights.
template <int D>
[[nodiscard]] double rounding_slack(const Model<D>& model) {
  const bool is_exact = !is_floating(model.info.type) && size_of(model.info.type) <= 4;
  if (is_exact || model.stats.min == model.stats.max) return 0;
  return 0x1p-47 * std::max(std::abs(model.stats.min), std::abs(model.stats.max));
}

}  // namespace lode::diamond
