// Included again by Highway for each instruction set: most count bits in one instruction.
#include "lode/models/terrain/right_triangle_bisection/sample_numbers.h"

#include <bit>

#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/terrain/right_triangle_bisection/sample_numbers.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::bisection::HWY_NAMESPACE {

void count(SampleMesh& mesh) {
  const std::vector<std::uint64_t>& words = mesh.marks.words();
  mesh.n_before.resize(words.size());
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    mesh.n_before[i] = n;
    n += static_cast<std::uint32_t>(std::popcount(words[i]));
  }
  mesh.n_samples = n;
}

void number(SampleMesh& mesh) {
  count(mesh);
  const std::vector<std::uint64_t>& words = mesh.marks.words();
  for (SampleCorners& corners : mesh.triangles)
    for (std::uint32_t& i : corners) {
      const std::uint64_t below = words[i / 64] & ((std::uint64_t{1} << (i % 64)) - 1);
      i = mesh.n_before[i / 64] + static_cast<std::uint32_t>(std::popcount(below));
    }
}

}  // namespace lode::bisection::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::bisection {

HWY_EXPORT(count);
HWY_EXPORT(number);

void count_samples(SampleMesh& mesh) { HWY_DYNAMIC_DISPATCH(count)(mesh); }

void number_samples(SampleMesh& mesh) { HWY_DYNAMIC_DISPATCH(number)(mesh); }

}  // namespace lode::bisection
#endif
