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

void number(const SampleMarks& marks, std::vector<SampleCorners>& triangles,
            std::vector<std::uint32_t>& used) {
  const std::vector<std::uint64_t>& words = marks.words();
  std::vector<std::uint32_t> n_before(words.size());
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    n_before[i] = n;
    n += static_cast<std::uint32_t>(std::popcount(words[i]));
  }
  used.reserve(n);
  for (std::size_t i = 0; i < words.size(); ++i)
    for (std::uint64_t word = words[i]; word != 0; word &= word - 1)
      used.push_back(static_cast<std::uint32_t>(64 * i) +
                     static_cast<std::uint32_t>(std::countr_zero(word)));
  for (SampleCorners& corners : triangles)
    for (std::uint32_t& i : corners) {
      const std::uint64_t below = words[i / 64] & ((std::uint64_t{1} << (i % 64)) - 1);
      i = n_before[i / 64] + static_cast<std::uint32_t>(std::popcount(below));
    }
}

}  // namespace lode::bisection::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::bisection {

HWY_EXPORT(number);

std::vector<std::uint32_t> number_samples(const SampleMarks& marks,
                                          std::vector<SampleCorners>& triangles) {
  std::vector<std::uint32_t> used;
  HWY_DYNAMIC_DISPATCH(number)(marks, triangles, used);
  return used;
}

}  // namespace lode::bisection
#endif
