#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

struct CountQuery {
  std::vector<double> isovalues;  ///< Finite, ascending, each once.
  double tolerance = 0;           ///< Field units; 0 is full resolution.
  Threads threads{};
};

/// What extract_isosurface() makes of one isovalue.
struct SurfaceCounts {
  std::uint64_t cells = 0;  ///< Triangles; lines in 2D.
  std::uint64_t vertices = 0;
};

/// The sizes of many isovalues' surfaces, in one pass over the hierarchy and without making any of
/// them: exactly those that extract_isosurface() has in the style of tetrahedra, one by one, in the
/// query's order. Where there are holes it keeps a list of the edges on bricks' borders, 16 bytes
/// each, else only some for each worker.
template <int D>
[[nodiscard]] Result<std::vector<SurfaceCounts>> count_isosurfaces(const Model<D>& model,
                                                                   const CountQuery& query,
                                                                   Progress& progress);

}  // namespace lode::diamond
