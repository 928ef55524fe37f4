#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/mappers/collapse_mesh.h"

namespace lode::simplification {

/// The triangles of a surface by cells of a regular lattice.
struct Partition {
  std::vector<std::uint32_t> triangles;  ///< Cell after cell, ascending within each.
  std::vector<std::uint32_t> first;      ///< Of cell i; one more than there are cells.
  std::vector<std::uint8_t> is_locked;   ///< By vertex: a triangle of it lies in two cells.
  std::vector<std::uint32_t> between;    ///< Those triangles.

  [[nodiscard]] std::size_t n_cells() const { return first.size() - 1; }
  [[nodiscard]] std::span<const std::uint32_t> cell(std::size_t i) const {
    return std::span(triangles).subspan(first[i], first[i + 1] - first[i]);
  }
};

/// Where the lattice lies: cells are cubes of this edge, one corner is at `origin`.
struct PartitionLattice {
  Vec3f origin;
  float edge = 0;
};

[[nodiscard]] Partition make_partition(const CollapseMesh& mesh, const PartitionLattice& lattice,
                                       Threads threads);

}  // namespace lode::simplification
