#pragma once

#include "lode/core/uninitialized_array.h"

namespace lode {

// For the memory that programs take themselves: prefer_huge_pages(memory, n_bytes).

}  // namespace lode
