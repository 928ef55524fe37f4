#pragma once

#include <string>

#include "input.h"
#include "output_folder.h"
#include "outputs.h"
#include "progressive_options.h"

namespace lode::cli {

/// The part of `lode extract` that writes a surface per step.
struct StepsJob {
  const OutputFolder& folder;
  const std::string& output;  ///< Whose extension the steps' files have.
  const ExtractOptions& options;
  const Input& input;
};

/// Writes step-000 and so on, and index.json, the last; returns what that holds.
[[nodiscard]] Result<Json> write_steps(const StepsJob& job, Session& session, OutputSet& outputs);

}  // namespace lode::cli
