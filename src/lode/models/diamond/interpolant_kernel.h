#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

#include "lode/models/diamond/cube_plan.h"

namespace lode::diamond {

/// Cubes computed side by side; array element [point * kLanes + lane].
inline constexpr std::size_t kLanes = 8;

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

enum class Holes : std::uint8_t { absent, present };

/// The arrays of one run; each has points · kLanes elements, 64-byte aligned.
template <typename C>
struct InterpolantArrays {
  const C* samples;   ///< NaN where a point must not count (outside the data, or a hole).
  const C* vertices;  ///< Values at vertices: samples, extended outside the data.
  C* values;          ///< Scratch: the interpolant.
};

/// Evaluates one interpolant on kLanes cubes and finds, per region and lane, the largest
/// |sample - value| (out[region * kLanes + lane], >= 0). With holes present, a finite sample
/// whose interpolant touches a hole makes that infinite. Bound by cache bandwidth: about six
/// vector accesses a point.
void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<float>& arrays,
                     Holes holes, float* out);
void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<double>& arrays,
                     Holes holes, double* out);

/// Interpolants that are linear on the Kuhn simplices of kLanes cubes, run_linear's input and
/// output. Always three of them, which share each sample they are compared with.
template <typename C>
struct LinearArrays {
  const C* samples;                 ///< As above.
  std::array<const C*, 3> corners;  ///< Each cube's 2^D values, bit i: far end of axis i; per lane.
  std::array<C*, 3> errors;         ///< The largest per Kuhn simplex; per lane.
};

/// As run_interpolant, per Kuhn simplex; simplices with a hole at a corner get any result. F' at a
/// point is a sum of at most 20 terms.
void run_linear(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<float>& arrays,
                Holes holes);
void run_linear(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<float>& arrays,
                Holes holes);
void run_linear(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<double>& arrays,
                Holes holes);
void run_linear(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<double>& arrays,
                Holes holes);

}  // namespace lode::diamond
