#pragma once

#include <cstdint>

#include <hwy/targets.h>

namespace lode::test {

/// Whose instructions vectors are made of; back to the best that the processor has when it ends.
struct SimdTargets {
  ~SimdTargets() { use(0); }
  /// 0: the best.
  static void use(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().DeInit();
  }
};

}  // namespace lode::test
