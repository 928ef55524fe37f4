#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/volume.h"
#include "tests/oracles/analytic_fields.h"

namespace lode::bench {

/// A volume to race on: an analytic field, noise, or a file of LODE_DATA/volume.
struct VolumeCase {
  std::string name;                     ///< "bonsai", "sphere_257", ...
  std::optional<oracles::Field> field;  ///< Unset: a file, or noise.
  std::int32_t n = 0;                   ///< Samples per axis of the field, or of noise.
  std::string file;
  std::string array;                 ///< Which of several fields in the file.
  std::optional<Index3> raw_dims{};  ///< Of a file of bare bytes.
  double isovalue = 0;
  double relative_error = 0.005;  ///< Of the value range, for the adaptive rows.
};

[[nodiscard]] std::vector<VolumeCase> volume_cases();

/// Runs a benchmark on the cases that its option --only allows, and says why where it cannot.
int run_cases(int argc, char** argv, const char* about,
              const std::function<Result<void>(const VolumeCase&)>& run);

/// The samples; an Error where the file is absent or unreadable.
[[nodiscard]] Result<Volume> load(const VolumeCase& volume_case);

}  // namespace lode::bench
