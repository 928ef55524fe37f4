#pragma once

#include <array>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// The nodes of level 0 that a node of level 0 and all below it are made of: what their nested
/// errors and ranges look at, relative to its centre. Depends on that modulo 4 only.
template <int D>
struct FinestNodes {
  struct Bisection {
    Index<D> centre, first, second;  ///< Of the bisected edge, and its ends.
  };
  std::vector<Bisection> bisections;  ///< One a node.
  std::vector<Index<D>> samples;      ///< Of their domains, each once.

  /// No sample is farther away along any axis.
  static constexpr std::int32_t kReach = 2;
};

template <int D>
[[nodiscard]] const FinestNodes<D>& finest_nodes(const Index<D>& centre);

extern template const FinestNodes<2>& finest_nodes<2>(const Index<2>&);
extern template const FinestNodes<3>& finest_nodes<3>(const Index<3>&);

}  // namespace lode::diamond
