#pragma once

#include "lode/models/diamond/block_order.h"

namespace lode::diamond {

/// The finest level of which a build that goes through a field part by part keeps everything.
inline constexpr int kKeptLevel = kChunkLevel + 1;

/// Of a field the samples and nodes of level kKeptLevel and coarser ones: of n samples n / 8^3.
template <int D>
struct CoarseField : LatticeField<D, CoarseField<D>> {
  Index<D> dims;                          ///< Of level kKeptLevel's grid.
  UninitializedArray<std::byte> samples;  ///< On it, x fastest; beyond the data the nearest ones.
  std::vector<NodeLevel> levels;          ///< Finest first; those below kKeptLevel are empty.
  WorldErrors worlds;                     ///< Of their nodes.
  /// Own errors of level kKeptLevel: its nodes of the lowest tier are joined with finer ones first.
  UninitializedArray<ErrorCode> finest_own;

  using LatticeField<D, CoarseField<D>>::shape;

  /// Without samples; errors are 0, and ranges empty. `is_built`: with world errors, and own ones.
  [[nodiscard]] static CoarseField make(const VolumeInfo& info, bool is_built = false);
  /// What it takes of memory.
  [[nodiscard]] static std::uint64_t n_bytes(const VolumeInfo& info, bool is_built = false);
  [[nodiscard]] bool is_needed() const { return shape.n_levels > kKeptLevel; }

  /// Takes those of a box of the field's samples (storage type, x fastest) that it keeps.
  void put_samples(const LatticeBox<D>& box, const std::byte* values);

  /// See NearSamples: there is no short way to any.
  template <typename Near>
  void find_near(Near& /*near*/, const Index<D>& /*centre*/, std::int32_t /*reach*/,
                 int /*level*/) const {}

  /// Nested error of the root; 0 when there are no cells.
  [[nodiscard]] double base_error() const;

  /// Takes the shares of nodes that another worker's parts have given to its own copy of the field.
  void join(const CoarseField& other);

  /// The sample at p, a point of the level's grid or one beyond the data.
  [[nodiscard]] double value(const Index<D>& p) const {
    Index<D> q;
    for (std::size_t i = 0; i < as_size(D); ++i)
      q[i] = std::clamp(p[i] >> kKeptLevel, 0, last_distinct(i));
    const std::size_t at = linear_index<D>(dims, q);
    return visit_storage_type(this->storage, [&]<typename T>() {
      T sample;
      std::memcpy(&sample, samples.data() + at * sizeof(T), sizeof(T));
      return static_cast<double>(sample);
    });
  }

 private:
  /// The first grid point at the last sample of an axis or beyond it.
  [[nodiscard]] std::int32_t last_distinct(std::size_t axis) const {
    return (shape.dims[axis] - 1 + (1 << kKeptLevel) - 1) >> kKeptLevel;
  }
};

extern template struct CoarseField<2>;
extern template struct CoarseField<3>;

}  // namespace lode::diamond
