#pragma once

#include <vector>

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// What a file's metadata say of the field and of its errors, so that questions about them need no
/// block.
struct Summary {
  FieldStats stats;
  double base_error = 0;           ///< Nested error of the unrefined base; may be infinite.
  std::vector<double> max_errors;  ///< Per level, finest first: the largest nested error of its
                                   ///< nodes (level 0: of those of tier 0); 0 without nodes.

  friend bool operator==(const Summary&, const Summary&) = default;
};

/// Takes one pass over the errors in memory.
template <int D>
[[nodiscard]] Summary summarize(const Model<D>& model);

}  // namespace lode::diamond
