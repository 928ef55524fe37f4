#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

#include "lode/models/diamond/sample_scale.h"

namespace lode::diamond {

/// Gives vectors the alignment the kernels load with.
template <typename C>
struct AlignedAllocator {
  using value_type = C;
  static constexpr std::align_val_t kAlignment{64};

  AlignedAllocator() = default;
  template <typename U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  [[nodiscard]] C* allocate(std::size_t n) {
    return static_cast<C*>(::operator new(n * sizeof(C), kAlignment));
  }
  void deallocate(C* p, std::size_t) { ::operator delete(p, kAlignment); }
  friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};

template <typename C>
using AlignedVector = std::vector<C, AlignedAllocator<C>>;

/// Which samples of a run may be NaN and do not count, or holes.
enum class Gaps : std::uint8_t {
  none,         ///< Not one of them.
  beyond_data,  ///< Points outside the data, where vertices have values all the same.
  holes         ///< Those; and holes are infinite, where vertices are NaN.
};

/// The arrays of one run: for each point of the plan's cube kLanesOf<C> values, one per cube;
/// 64-byte aligned.
template <typename C>
struct InterpolantArrays {
  const C* samples;   ///< kNoSample where a point must not count, infinite where a hole is.
  const C* vertices;  ///< Values at vertices: samples, extended outside the data.
  C* values;          ///< Scratch: the interpolant.
};

/// Evaluates one interpolant on kLanesOf<C> cubes and finds, per region and lane, the largest
/// |sample - value| (out[region * kLanesOf<C> + lane], >= 0). With holes, which steps have not, it
/// is infinite where one of the two is a hole's and the other is not. Bound by cache bandwidth:
/// about six vector accesses a point.
void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<float>& arrays, Gaps gaps,
                     float* out);
void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<double>& arrays,
                     Gaps gaps, double* out);
void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<Step>& arrays, Gaps gaps,
                     Step* out);

/// Of n_points points with kLanesOf<Step> values each the first kLanes as floats, kLanes a point:
/// smallest + size * step, NaN for kNoSample.
void widen_lanes(const Step* from, std::size_t n_points, float smallest, float size, float* to);

/// Interpolants that are linear on the Kuhn simplices of kLanes cubes, run_linear's input and
/// output. Always three of them, which share each sample they are compared with.
template <typename C>
struct LinearArrays {
  const C* samples;                 ///< As above.
  std::array<const C*, 3> corners;  ///< Each cube's 2^D values, bit i: far end of axis i; per lane.
  std::array<C*, 3> errors;         ///< The largest per Kuhn simplex; per lane.
};

/// As run_interpolant, per Kuhn simplex; one with a hole at a corner gets 0. F' at a point is a sum
/// of at most 20 terms.
void run_linear(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<float>& arrays,
                Gaps gaps);
void run_linear(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<float>& arrays,
                Gaps gaps);
void run_linear(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<double>& arrays,
                Gaps gaps);
void run_linear(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<double>& arrays,
                Gaps gaps);

}  // namespace lode::diamond
