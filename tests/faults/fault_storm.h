#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "tests/faults/fault_injector.h"

namespace lode::test {

/// Something that the library does, to be done again and again while one call after the other
/// fails.
struct Operation {
  /// Of these an error of reading or writing names one.
  std::vector<std::string> files;
  std::function<void()> prepare = [] {};      ///< As it was before.
  std::function<Result<void>()> run;          ///< The only part in which calls fail.
  std::function<void()> expect_done = [] {};  ///< All that it gives is there, and right.
  /// What was there before still is, and no more.
  std::function<void(const std::string& message)> expect_undone = [](const std::string&) {};
  /// Goes on after a failure; unset: run().
  std::function<Result<void>()> run_again = {};
};

/// Lets each of the operation's calls of one kind fail, alone and with all later ones: it must come
/// to an error that says where and what, leave nothing behind, or else give all that it gives
/// without a fault; afterwards it must succeed. Where there are many calls, a seeded sample of
/// them, unless LODE_FAULTS is "all".
void expect_survives(const Operation& operation, Fault fault);

/// The same for every kind.
void expect_survives_all(const Operation& operation);

/// Skips the tests where a sanitizer keeps calls from being made to fail.
class FaultTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_inject_faults()) GTEST_SKIP() << "a sanitizer stands between library and system";
  }
};

}  // namespace lode::test
