#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "lode/mappers/iso_part.h"

namespace lode {

/// A simplex of any hierarchy on the lattice, with the field's values at its vertices.
template <int D>
struct LatticeSimplex {
  std::array<LatticeKey, static_cast<std::size_t>(D) + 1> vertex;
  std::array<double, static_cast<std::size_t>(D) + 1> value;
};

/// Marching simplices over batches: value >= isovalue is inside, each crossed edge has one vertex
/// per part. Cells are counter-clockwise seen from lower values (2D: lower values on the right)
/// in lattice coordinates as in world ones, mirrored frames included.
template <int D>
class SimplexIsosurface {
 public:
  SimplexIsosurface(const LatticeFrame& frame, double isovalue, IsoPart<D>& part);

  void add(const LatticeSimplex<D>& simplex);

 private:
  std::uint32_t vertex_on(const LatticeSimplex<D>& simplex, std::size_t i, std::size_t j);
  void grow();

  double isovalue_;
  double margin_;
  bool is_mirrored_;
  IsoPart<D>& part_;
  std::vector<std::uint32_t> slots_;  ///< Open addressing by doubled midpoint; id + 1.
};

extern template class SimplexIsosurface<2>;
extern template class SimplexIsosurface<3>;

}  // namespace lode
