#pragma once

#include "tests/faults/fault_injector.h"

namespace lode::test {

/// Whether this call, which counts, is one that the plan wants to fail; errno is set then.
/// `caller`: the place it returns to.
[[nodiscard]] bool must_fail(Fault fault, const void* caller);

}  // namespace lode::test
