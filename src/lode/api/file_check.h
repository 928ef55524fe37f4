#pragma once

#include <string>

#include "lode/api/verify_report.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode {

/// Checks every byte of a .lode file of any model: checksums, and that all blocks decode. Fails on
/// the first fault, naming the file.
[[nodiscard]] Result<VerifyReport> verify_every_byte(const std::string& path, Threads threads,
                                                     Progress& progress);

}  // namespace lode
