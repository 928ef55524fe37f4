#pragma once

#include <string>
#include <vector>

#include "command.h"

namespace lode::cli {

/// Which heights contours are wanted of, as typed.
struct LevelArguments {
  std::string interval;
  std::string base;
  std::vector<std::string> isovalues;
};

void add_level_options(CLI::App& app, LevelArguments& arguments);

/// Heights that rise strictly: those given, or base + k interval above the lowest height and up to
/// the highest.
struct ContourLevels {
  std::vector<double> given;  ///< Empty: interval and base.
  double interval = 0;
  double base = 0;

  /// Fails where there are millions.
  [[nodiscard]] Result<std::vector<double>> within(double lowest, double highest) const;
};

[[nodiscard]] Result<ContourLevels> to_levels(const LevelArguments& arguments);

}  // namespace lode::cli
