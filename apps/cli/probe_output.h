#pragma once

#include <string>
#include <vector>

#include "command.h"
#include "lode/api/probe.h"
#include "text.h"

namespace lode::cli {

/// What `lode probe` has found, of one kind.
struct ProbeAnswer {
  ProbeReport report;
  std::vector<ProbedPoint> points;
  std::vector<ProbedLinePoint> line;
  std::optional<IntegralReport> integral;
  bool has_regions = false;         ///< Several.
  std::vector<std::string> with{};  ///< Names of further fields.
};

/// Rows for people, in as many digits as tables have; for programs, that read numbers back as they
/// are; and to a file likewise, with a heading.
[[nodiscard]] std::string probe_table(const ProbeAnswer& answer);
[[nodiscard]] Json probe_json(const ProbeAnswer& answer);
[[nodiscard]] std::string probe_csv(const ProbeAnswer& answer);

}  // namespace lode::cli
