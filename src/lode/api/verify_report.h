#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace lode {

/// What a verification looked at, and the first thing that failed (empty: all holds).
struct VerifyReport {
  struct Check {
    std::string name;         ///< "no self-intersection", ...
    std::uint64_t count = 0;  ///< How many things were checked.
    bool passed = true;
    std::string detail;    ///< Measured worst value, or the worst offender.
    bool skipped = false;  ///< Not looked at: nothing is known, and the detail says why.
  };
  std::vector<Check> checks;

  void add(std::string name, std::uint64_t count, std::uint64_t failures, std::string detail) {
    checks.push_back({std::move(name), count, failures == 0, std::move(detail)});
  }
  void skip(std::string name, std::string why) {
    checks.push_back({std::move(name), 0, true, std::move(why), true});
  }
  /// No check that was made failed.
  [[nodiscard]] bool passed() const {
    for (const Check& check : checks)
      if (!check.passed) return false;
    return true;
  }
};

}  // namespace lode
