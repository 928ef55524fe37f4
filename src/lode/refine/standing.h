#pragma once

#include <cstdint>

namespace lode {

/// Where the engine stands after a step.
struct Standing {
  std::uint64_t n_steps = 0;    ///< Since the query was set.
  std::uint64_t n_applied = 0;  ///< Nodes in the cut.
  std::uint64_t n_cells = 0;    ///< Simplices of its mesh.
  /// Largest nested field error left unrefined in focus; infinite while that is not known, since
  /// an earlier cut is being looked through for a new focus.
  double error_bound = 0;
  bool is_settled = false;    ///< The answer: nothing is left to do.
  bool awaits_data = false;   ///< Nothing is left to do until pages of the model arrive.
  bool budget_met = true;     ///< False, once settled: even the base is larger.
  bool budget_ended = false;  ///< Settled, and more would be refined if the budget were larger.
  /// False: memory is short of pages for what is wanted more than all else.
  bool memory_met = true;
  bool is_nested = true;  ///< False: a demand was seen to grow along discovery, which is no error,
                          ///< but then the cut may depend on where it started.

  friend bool operator==(const Standing&, const Standing&) = default;
};

}  // namespace lode
