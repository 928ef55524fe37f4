#pragma once

#include <utility>

#include "tests/fuzz/harnesses.h"

namespace lode::fuzz {

/// An input that stands for two: the length of the first in its first two bytes, low byte first.
inline std::pair<Input, Input> split(Input input) {
  if (input.size() < 2) return {input, {}};
  const std::size_t wanted =
      std::to_integer<std::size_t>(input[0]) | std::to_integer<std::size_t>(input[1]) << 8U;
  const Input rest = input.subspan(2);
  const std::size_t n = wanted < rest.size() ? wanted : rest.size();
  return {rest.first(n), rest.subspan(n)};
}

}  // namespace lode::fuzz
