#pragma once

#include <hwy/targets.h>

#include <cstdint>

#include <gtest/gtest.h>

namespace lode::test {

/// Back to the best that the processor has.
struct AllTargets {
  AllTargets() { use(0); }
  ~AllTargets() { use(0); }
  AllTargets(const AllTargets&) = delete;
  AllTargets& operator=(const AllTargets&) = delete;

  static void use(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().DeInit();
  }
};

/// Calls body() with each kind of vectors that the processor has, and that alone.
template <typename Body>
void for_each_target(const Body& body) {
  const AllTargets restored;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    SCOPED_TRACE(hwy::TargetName(left & -left));
    AllTargets::use(left & -left);
    body();
    AllTargets::use(0);
  }
}

}  // namespace lode::test
