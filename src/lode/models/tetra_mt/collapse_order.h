#pragma once

#include <cstdint>

namespace lode::tetra_mt {

/// Of which the vertex that goes next makes least, for each cell that goes with it.
enum class CollapseOrder : std::uint8_t {
  squared_error,  ///< What errors at all samples cost: cost_of().
  /// The same of distances: how far from a sample F' has its value, as shares of the mesh's size
  /// (Cignoni and others 2004, section 3), to first order: the error by the gradient's length.
  space_error,
  /// By how much the value of the vertex that stays differs from what tetrahedra that were round
  /// the one that goes, or went into it, would have there: no sample is looked at.
  quadric,
};

}  // namespace lode::tetra_mt
