#pragma once

#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::bench {

struct TetraCase {
  std::string name;
  std::string file{};  ///< Of LODE_DATA/tetra; none: noise.
  std::string field{};
  int noise_samples = 0;  ///< An axis.
  oracles::Cut cut = oracles::Cut::in_five;
};

/// Noise of 64 samples an axis.
[[nodiscard]] TetraCase noise_case(oracles::Cut cut);
/// Real ones: blunt fin and oxygen post.
[[nodiscard]] std::vector<TetraCase> real_tetra_cases();

/// An Error that begins with "skipped" where the file is absent.
[[nodiscard]] Result<TetraMesh> load(const TetraCase& tetra_case);

}  // namespace lode::bench
