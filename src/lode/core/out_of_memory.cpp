#include "lode/core/out_of_memory.h"

#include <new>

namespace lode {

Error out_of_memory(std::string_view action, std::string_view path) noexcept {
  try {
    return fail("{}{}not enough memory to {}", path, path.empty() ? "" : ": ", action);
  } catch (const std::bad_alloc&) {
    return Error("out of memory");  // short enough to need none
  }
}

}  // namespace lode
