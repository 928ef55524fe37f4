#pragma once

#include <cstdint>
#include <vector>

#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// Nodes by their numbers in a list that grows, and outlives this.
class GrownNodes {
 public:
  explicit GrownNodes(const std::vector<LatticePoint>& nodes) : nodes_(&nodes) {}

  [[nodiscard]] LatticePoint unpack(std::uint32_t number) const { return (*nodes_)[number]; }

 private:
  const std::vector<LatticePoint>* nodes_;
};

}  // namespace lode::delaunay
