#include "lode/core/expects.h"

#include <cstdio>
#include <cstdlib>

namespace lode {

void broken_expectation(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "lode: broken expectation at %s:%d: %s\n", file, line, condition);
  std::abort();
}

}  // namespace lode
