#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "extraction_options.h"
#include "lode/api/progressive.h"

namespace lode::cli {

/// The options of surfaces from coarse to fine as typed.
struct ProgressiveArguments {
  std::string directory;
  std::string frames_per_step;  ///< Of pictures only.

  [[nodiscard]] bool is_wanted() const { return !directory.empty(); }
};

void add_progressive_option(CLI::App& app, ProgressiveArguments& arguments, const char* help);

/// Looks at the arguments alone; other checks have passed.
[[nodiscard]] Result<void> check_progressive(const ProgressiveArguments& arguments,
                                             const ExtractionArguments& extraction);

/// The keys of one step's surface.
[[nodiscard]] Json step_json(const ProgressiveStep& step, const Surface& surface);

}  // namespace lode::cli
