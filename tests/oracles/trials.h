#pragma once

#include <cstdlib>
#include <string_view>
#include <utility>

namespace lode::oracles {

/// Of all that a test tries, what it takes in a fast run: a part in which every kind of case is.
/// The slow tests set LODE_TRIALS=all and take all.
template <typename T>
[[nodiscard]] T trials(T all, T part) {
  const char* wanted = std::getenv("LODE_TRIALS");
  return wanted != nullptr && std::string_view(wanted) == "all" ? std::move(all) : std::move(part);
}

}  // namespace lode::oracles
