#pragma once

#include <string_view>

#include "lode/core/result.h"

namespace lode {

/// What the functions that a program calls make of std::bad_alloc: "PATH: not enough memory to
/// ACTION", without an empty path; just "out of memory" where there is none even for that.
[[nodiscard]] Error out_of_memory(std::string_view action, std::string_view path = {}) noexcept;

}  // namespace lode
