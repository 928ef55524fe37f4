#pragma once

#include <cstddef>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/result.h"

namespace lode {

/// Runs body(i), a Result<void>, for all i below n, in parallel. Returns the first failure in the
/// order of i, whatever came first.
template <typename Body>
[[nodiscard]] Result<void> check_all(std::size_t n, Threads threads, const Body& body) {
  std::vector<Error> errors(n);
  parallel_for(n, threads, 1, [&](std::size_t i, int) {
    if (auto done = body(i); !done) errors[i] = done.error();
  });
  for (const Error& error : errors)
    if (!error.message.empty()) return error;
  return {};
}

}  // namespace lode
