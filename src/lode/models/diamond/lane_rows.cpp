#include "lode/models/diamond/lane_rows.h"

// Each target is another copy of this file to compile.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/lane_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// As many elements as 16 bytes hold: so many rows and columns are transposed in registers.
template <typename V>
using BlockTag = hn::Full128<V>;
template <typename V>
inline constexpr std::size_t kBlock = 16 / sizeof(V);

/// Points x .. x + kBlock - 1 of the rows of kBlock lanes.
template <typename V>
HWY_INLINE void interleave_block(const LaneCube<V>* lanes, std::size_t y, std::size_t z,
                                 std::size_t x, std::size_t n_lanes, V* out) {
  const BlockTag<V> d;
  constexpr std::size_t n = kBlock<V>;
  hn::Vec<BlockTag<V>> rows[n];  // NOLINT(modernize-avoid-c-arrays): stays in registers
  for (std::size_t i = 0; i < n; ++i) {
    const LaneCube<V>& lane = lanes[i];
    const V* const first = lane.origin + static_cast<std::ptrdiff_t>(x) * lane.step[0] +
                           static_cast<std::ptrdiff_t>(y) * lane.step[1] +
                           static_cast<std::ptrdiff_t>(z) * lane.step[2];
    if (lane.step[0] > 0)
      rows[i] = hn::LoadU(d, first);
    else
      rows[i] = hn::Reverse(d, hn::LoadU(d, first - (n - 1)));
  }
  // Interleaving each half of the rows with the other, as often as they can be halved.
  for (std::size_t width = n; width > 1; width /= 2) {
    hn::Vec<BlockTag<V>> mixed[n];  // NOLINT(modernize-avoid-c-arrays)
    for (std::size_t i = 0; i < n / 2; ++i) {
      mixed[2 * i] = hn::InterleaveLower(d, rows[i], rows[i + n / 2]);
      mixed[2 * i + 1] = hn::InterleaveUpper(d, rows[i], rows[i + n / 2]);
    }
    for (std::size_t i = 0; i < n; ++i) rows[i] = mixed[i];
  }
  for (std::size_t i = 0; i < n; ++i) hn::StoreU(rows[i], d, out + i * n_lanes);
}

template <typename V>
HWY_INLINE void interleave(std::span<const LaneCube<V>> cubes, const std::array<std::size_t, 3>& n,
                           V* out) {
  const std::size_t n_lanes = cubes.size();
  for (std::size_t z = 0; z < n[2]; ++z)
    for (std::size_t y = 0; y < n[1]; ++y, out += n[0] * n_lanes) {
      for (std::size_t lane = 0; lane < n_lanes; lane += kBlock<V>)
        for (std::size_t x = 0; x + 1 < n[0]; x += kBlock<V>)
          interleave_block(&cubes[lane], y, z, x, n_lanes, out + x * n_lanes + lane);
      for (std::size_t lane = 0; lane < n_lanes; ++lane) {
        const LaneCube<V>& cube = cubes[lane];
        out[(n[0] - 1) * n_lanes + lane] =
            cube.origin[static_cast<std::ptrdiff_t>(n[0] - 1) * cube.step[0] +
                        static_cast<std::ptrdiff_t>(y) * cube.step[1] +
                        static_cast<std::ptrdiff_t>(z) * cube.step[2]];
      }
    }
}

// Highway exports functions, not templates.
void interleave_steps(std::span<const LaneCube<std::uint16_t>> cubes,
                      const std::array<std::size_t, 3>& n, std::uint16_t* out) {
  interleave(cubes, n, out);
}
void interleave_floats(std::span<const LaneCube<float>> cubes, const std::array<std::size_t, 3>& n,
                       float* out) {
  interleave(cubes, n, out);
}
void interleave_doubles(std::span<const LaneCube<double>> cubes,
                        const std::array<std::size_t, 3>& n, double* out) {
  interleave(cubes, n, out);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(interleave_steps);
HWY_EXPORT(interleave_floats);
HWY_EXPORT(interleave_doubles);

void interleave_cubes(std::span<const LaneCube<std::uint16_t>> cubes,
                      const std::array<std::size_t, 3>& n, std::uint16_t* out) {
  HWY_DYNAMIC_DISPATCH(interleave_steps)(cubes, n, out);
}
void interleave_cubes(std::span<const LaneCube<float>> cubes, const std::array<std::size_t, 3>& n,
                      float* out) {
  HWY_DYNAMIC_DISPATCH(interleave_floats)(cubes, n, out);
}
void interleave_cubes(std::span<const LaneCube<double>> cubes, const std::array<std::size_t, 3>& n,
                      double* out) {
  HWY_DYNAMIC_DISPATCH(interleave_doubles)(cubes, n, out);
}

}  // namespace lode::diamond
#endif
