#pragma once

#include <string>

#include "input.h"

namespace lode::cli {

/// `lode verify` of a mesh of cells, or of a .lode file of tetrahedra.
struct TetraVerifyJob {
  std::string input;
  std::string original;  ///< What it was made from; or empty.
  bool is_exact = false;
  ReadingArguments reading;
};

[[nodiscard]] Result<void> check_tetra_verify(const TetraVerifyJob& job);

/// A .lode file's bytes, then the hierarchy that it holds, or that is built in memory, then whether
/// it is the original's.
[[nodiscard]] Result<VerifyReport> verify_tetra(const TetraVerifyJob& job, Session& session);

}  // namespace lode::cli
