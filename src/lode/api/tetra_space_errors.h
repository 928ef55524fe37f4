#pragma once

#include <cstdint>

#include "lode/api/tetra_cut_shape.h"
#include "lode/core/parallel.h"

namespace lode {

/// How far vertices of the reference mesh are from where a cut has their value: the paper's space
/// error (Cignoni, De Floriani, Magillo, Puppo, Scopigno 2004, section 3) at these, found among all
/// cells; in the mesh's unit. Values that differ by no more than tetra_mt::kSameValue are the same.
struct TetraSpaceErrors {
  std::uint64_t n_vertices = 0;
  std::uint64_t n_above = 0;  ///< Farther than is stated.
  std::uint64_t n_lost = 0;   ///< Whose value no cell has: they count in nothing else.
  double largest = 0;
  double root_mean_square = 0;
};

/// `vertices`: with a field's values; `stated`: what the cut achieves. The same for any number of
/// threads.
[[nodiscard]] TetraSpaceErrors measure_space_errors(const TetraVertices& vertices,
                                                    const TetraCells& cells, double stated,
                                                    Threads threads);

}  // namespace lode
