#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/edge_vertices.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Of gradients of whole slices, two of them: beyond as many bytes a thread keeps some rows.
inline constexpr std::size_t kMostGradientBytes = std::size_t{1} << 24;

/// What holds differences of samples, and halves of them, as doubles do.
template <typename T>
using GradientOf = std::conditional_t<sizeof(T) <= 2, float, double>;

/// Samples of a row whose gradients are found together: half a brick's.
inline constexpr std::size_t kGradientRun = 16;

/// The samples round a run of them along x, behind which there is one more.
template <typename T>
struct RunNeighbours {
  const T* run;                    ///< Those themselves.
  const T* before;                 ///< The sample before the first one.
  std::array<const T*, 2> low{};   ///< Along y and z what is beside them, or where there is
  std::array<const T*, 2> high{};  ///< nothing those themselves.
  std::array<double, 2> scale{};   ///< One by how far these are apart.
};

/// Gradients by central differences, four numbers each: along x, y and z, and 0. Along x both
/// neighbours are taken to be there, and that before the run's first sample is run[-1].
void find_gradients(const RunNeighbours<std::uint8_t>& from, float* out);
void find_gradients(const RunNeighbours<std::uint16_t>& from, float* out);
void find_gradients(const RunNeighbours<std::int16_t>& from, float* out);
void find_gradients(const RunNeighbours<float>& from, double* out);
void find_gradients(const RunNeighbours<double>& from, double* out);

/// Where the gradients of two slices' points are, those of other rows in the same places.
struct GradientPlaces {
  std::uint32_t row_length = 0;  ///< From one row's first point to the next one's.
  std::uint32_t n_rows = 0;      ///< Of each slice, a power of two.

  [[nodiscard]] std::uint32_t row(std::int32_t y, std::int32_t z) const {
    return (static_cast<std::uint32_t>(z & 1) * n_rows +
            (static_cast<std::uint32_t>(y) & (n_rows - 1))) *
           row_length;
  }
};

/// The places of both ends of n edges, packed_edge() of a run that begins with row (y, z). There is
/// room for kEdgePadding more.
struct EdgePlaces {
  const std::uint32_t* edges;
  std::size_t n;
  std::int32_t y, z;
  std::uint32_t* first;
  std::uint32_t* second;
};
void find_places(const GradientPlaces& places, const EdgePlaces& of);

/// Gradients at the finest lattice's points in rows near each other, in steps of the lattice: found
/// where they are wanted, and kept until other rows take their places. Central differences,
/// one-sided at the data's ends: as NormalSampler::gradient() has them, to the bit. T: the storage
/// of a model without holes.
template <typename T>
class GradientRows {
 public:
  using Gradient = GradientOf<T>;

  explicit GradientRows(const Model<3>& model)
      : model_(&model), n_runs_(kRunsPerBrick * as_size(model.brick_dims[0]) + 1) {
    places_.row_length = static_cast<std::uint32_t>(n_runs_ * kGradientRun);
    places_.n_rows = row_count();
  }

  /// Finds gradients at both ends of the crossed edges of a row of anchors.
  void find(std::int32_t y, std::int32_t z, std::span<const WordGroup> groups) {
    if (gradients_.empty()) {
      gradients_.resize(std::size_t{8} * places_.n_rows * places_.row_length);
      found_.assign(2 * places_.n_rows * n_runs_, kNothing);
    }
    for (const WordGroup& group : groups)
      for (std::uint32_t words = group.met; words != 0; words &= words - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(words));
        std::uint32_t crossed = 0;
        for (std::size_t s = 0; s < kOwnSeries; ++s) crossed |= group.crossings[i][s];
        for (std::size_t run = kRunsPerBrick * (group.first + i); crossed != 0;
             ++run, crossed >>= kGradientRun) {
          if ((crossed & 0xFFFFU) != 0) find_round(run, y, z);
          if ((crossed & 0x8000U) != 0 && has_samples(run + 1)) find_round(run + 1, y, z);
        }
      }
  }
  [[nodiscard]] const GradientPlaces& places() const { return places_; }
  /// By place, four numbers each.
  [[nodiscard]] const Gradient* gradients() const { return gradients_.data(); }

 private:
  static constexpr std::size_t kRunsPerBrick = as_size(kBrickEdge<3>) / kGradientRun;
  static constexpr std::uint64_t kNothing = ~std::uint64_t{0};

  /// Of each slice: all, or, where those of two slices would be too many, twice those that a run of
  /// edges is of.
  [[nodiscard]] std::uint32_t row_count() const {
    constexpr std::uint32_t kFew = 2 * kRowsPerRun;
    static_assert(std::has_single_bit(kFew));
    const std::uint32_t all = std::bit_ceil(static_cast<std::uint32_t>(model_->shape.dims[1]));
    const std::size_t n_bytes = 8 * sizeof(Gradient) * places_.row_length * all;
    return n_bytes <= kMostGradientBytes ? all : std::min(all, kFew);
  }

  [[nodiscard]] bool has_samples(std::size_t run) const {
    return run * kGradientRun < as_size(model_->shape.dims[0]);
  }
  /// In the four rows that edges of a row of anchors end in.
  void find_round(std::size_t run, std::int32_t y, std::int32_t z) {
    for (std::int32_t dz = 0; dz < 2; ++dz)
      for (std::int32_t dy = 0; dy < 2; ++dy)
        if (y + dy < model_->shape.dims[1] && z + dz < model_->shape.dims[2])
          find_run(run, y + dy, z + dz);
  }
  void find_run(std::size_t run, std::int32_t y, std::int32_t z) {
    const std::size_t first = places_.row(y, z) + run * kGradientRun;
    std::uint64_t& found = found_[first / kGradientRun];
    const std::uint64_t row = static_cast<std::uint64_t>(z) << 32 | static_cast<std::uint32_t>(y);
    if (found == row) return;
    found = row;
    put_run(run, y, z, gradients_.data() + 4 * first);
  }
  /// What lies beyond the data comes as it may. The rows that come next are asked for.
  void put_run(std::size_t run, std::int32_t y, std::int32_t z, Gradient* out) const {
    // A row's last sample may be a run of its own, which the brick before has.
    const bool is_one = run + 1 == n_runs_;
    const auto first = static_cast<std::int32_t>(run * kGradientRun);
    const RunNeighbours<T> from = neighbours(first, is_one, {y, z});
    __builtin_prefetch(from.high[1] + 4 * kBrickSamples<3>);
    if (is_one || first + y + z == 0)  // before the first one nothing may be read
      put_one_by_one(from, is_one ? 1 : kGradientRun, out);
    else
      find_gradients(from, out);
    const std::int32_t last = model_->shape.dims[0] - 1 - first;
    put_along(*from.before, from.run[last == 0 ? 0 : 1], first == 0 || last == 0 ? 1 : 0.5, out);
    if (last > 0 && as_size(last) < kGradientRun)
      put_along(from.run[last - 1], from.run[last], 1, out + 4 * last);
  }
  /// Of the run from x = first on in the row `p`, y and z.
  [[nodiscard]] RunNeighbours<T> neighbours(std::int32_t first, bool is_one,
                                            const std::array<std::int32_t, 2>& p) const {
    constexpr auto kRow = static_cast<std::ptrdiff_t>(kBrickSamples<3>);
    constexpr std::array<std::ptrdiff_t, 2> kUp{kRow, kRow * kRow};
    constexpr auto kBrick = static_cast<std::ptrdiff_t>(kBrickSize<3>);
    const std::int32_t x = is_one ? kBrickEdge<3> : first % kBrickEdge<3>;
    std::ptrdiff_t offset = (first - x) / kBrickEdge<3> * kBrick + x;
    std::ptrdiff_t bricks = model_->brick_dims[0] * kBrick;  // from a brick to the next one
    RunNeighbours<T> from{};
    std::array<std::ptrdiff_t, 2> down{};
    std::array<std::ptrdiff_t, 2> up{};
    for (std::size_t a = 0; a < 2; ++a) {
      const std::int32_t b = std::min(p[a] / kBrickEdge<3>, model_->brick_dims[a + 1] - 1);
      const std::int32_t local = p[a] - b * kBrickEdge<3>;
      offset += b * bricks + local * kUp[a];
      if (local > 0) down[a] = -kUp[a];
      if (local == 0 && b > 0) down[a] = (kBrickEdge<3> - 1) * kUp[a] - bricks;
      if (p[a] + 1 < model_->shape.dims[a + 1]) up[a] = kUp[a];
      from.scale[a] = down[a] != 0 && up[a] != 0 ? 0.5 : 1;
      bricks *= model_->brick_dims[a + 1];
    }
    from.run = reinterpret_cast<const T*>(model_->samples.data()) + offset;
    from.before = first == 0 ? from.run : from.run + (x > 0 ? -1 : kBrickEdge<3> - 1 - kBrick);
    for (std::size_t a = 0; a < 2; ++a) {
      from.low[a] = from.run + down[a];
      from.high[a] = from.run + up[a];
    }
    return from;
  }
  static void put_one_by_one(const RunNeighbours<T>& from, std::size_t n, Gradient* out) {
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) put_along(from.run[i - 1], from.run[i + 1], 0.5, out + 4 * i);
      for (std::size_t a = 0; a < 2; ++a)
        put_along(from.low[a][i], from.high[a][i], from.scale[a], out + 4 * i + a + 1);
      out[4 * i + 3] = 0;
    }
  }
  static void put_along(T low, T high, double scale, Gradient* out) {
    *out = static_cast<Gradient>((static_cast<double>(high) - static_cast<double>(low)) * scale);
  }

  const Model<3>* model_;
  std::size_t n_runs_;  ///< Along x.
  GradientPlaces places_;
  UninitializedArray<Gradient> gradients_;
  std::vector<std::uint64_t> found_;  ///< By run in gradients_, the row that it is of.
};

}  // namespace lode::diamond
