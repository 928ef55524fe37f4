#pragma once

#include <array>
#include <cstdint>

#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// Heights at all nodes of a lattice; of those outside the domain any, even none that are numbers.
/// From every sample on HeightGrid::kPadding more may be read.
template <typename T>
struct SampleRows {
  const T* samples = nullptr;
  std::int64_t stride = 0;  ///< Samples from row to row.
  LatticePacking packing{1};
  int spacing_bits = 0;  ///< Samples are of columns and rows that are multiples of 2^this.

  /// With spacing_bits 0.
  [[nodiscard]] double height(LatticePoint p) const {
    return static_cast<double>(samples[p.y * stride + p.x]);
  }
};

/// How far computed errors may be from the true ones |height - plane|, by rounding: of a triangle
/// with the doubled area A and a bounding box of w by h steps at most
/// plain + per_stretch * w h / A, and where a box is looked at as a whole per_rise times how far
/// the plane rises over its width and its height more. Derived in docs/models/delaunay_selector.md.
struct RoundingSlack {
  double plain = 0;
  double per_stretch = 0;
  double per_rise = 0;

  [[nodiscard]] double of(double stretch) const { return plain + per_stretch * stretch; }
};

/// Of heights within [lower, upper]: of float32 arithmetic for samples of up to four bytes, else of
/// float64, and of float64 arithmetic for all.
template <typename T>
[[nodiscard]] RoundingSlack lane_slack(double lower, double upper);
[[nodiscard]] RoundingSlack double_slack(double lower, double upper);

/// The worst sample in a closed triangle: no sample in it errs by more than `error`, and the one at
/// `node` errs by at least error - 2 slack. No node: all errors are computed as zero. Of samples
/// with equal computed errors it is the first.
struct WorstSample {
  static constexpr std::uint32_t kNone = 0xffffffff;

  double error = 0;
  std::uint32_t node = kNone;  ///< Packed.
  double slack = 0;
};

/// Looks at all nodes that there are samples of in the triangle whose corners are given, packed,
/// turning left, and whose heights there are z. With the same result for any instruction set.
/// Corners are looked at, too: one may be named where the error is below twice the slack.
template <typename T>
using FindWorst = WorstSample (*)(const SampleRows<T>& rows, const RoundingSlack& slack,
                                  const std::array<std::uint32_t, 3>& corners,
                                  std::array<double, 3> z);

/// The one for this processor.
template <typename T>
[[nodiscard]] FindWorst<T> find_worst_sample();

/// The same but for corners, which are not named, slower: of integers exactly, but for rounding the
/// error itself up; of others in float64.
template <typename T>
[[nodiscard]] WorstSample find_worst_exactly(const SampleRows<T>& rows, const RoundingSlack& slack,
                                             const std::array<std::uint32_t, 3>& corners);

/// The same of floats, but of nodes strictly inside a part alone: those on its border are neither
/// looked at nor named.
template <typename T>
[[nodiscard]] WorstSample find_worst_inside(const SampleRows<T>& rows, const RoundingSlack& slack,
                                            const std::array<std::uint32_t, 3>& corners,
                                            const LatticePart& part);

}  // namespace lode::delaunay
