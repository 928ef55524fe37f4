#pragma once

#include <vector>

#include "bench/volume_cases.h"

namespace lode::bench {

/// A data set of the paper's tables with what they say of it, in seconds.
struct PaperCase {
  struct Extraction {
    double share = 0;  ///< Of full resolution.
    double with_s = 0;
    double without_s = 0;
  };
  std::string name;   ///< Ours.
  std::string paper;  ///< Theirs.
  VolumeCase volume;  ///< Without file and field: the hydrogen atom of the oracles.
  double build_s = 0;
  std::vector<Extraction> extractions;  ///< Times are 0 where the paper has none.
};

[[nodiscard]] std::vector<PaperCase> paper_cases();

/// The samples; an Error where the file is absent or unreadable.
[[nodiscard]] Result<Volume> load(const PaperCase& paper_case);

}  // namespace lode::bench
