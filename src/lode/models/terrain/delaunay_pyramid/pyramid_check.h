#pragma once

#include <cstddef>
#include <cstdint>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"

namespace lode::delaunay_pyramid {

/// What verification finds of a pyramid that PyramidFile::read_all() gave, or encode().
struct PyramidFaults {
  std::uint64_t n_links = 0;         ///< That were looked at.
  std::uint64_t n_owners = 0;        ///< Triangles that have links.
  std::uint64_t n_wrong_owners = 0;  ///< With other links than to just what meets their interiors.
  std::uint64_t n_line_levels = 0;   ///< Levels where a line is no edge, nor a chain of edges.
  std::uint64_t n_other_angles = 0;  ///< Levels whose mesh has other angles than the file says.
  std::uint64_t n_other_levels = 0;  ///< Levels whose mesh is not Delaunay but for lines.
};

/// Links are held against a walk through the neighbours of what they lead to, with exact tests:
/// what meets a triangle's interior is connected. O(links) usually. Fails when cancelled.
[[nodiscard]] Result<PyramidFaults> find_faults(const Pyramid& pyramid, Progress& progress);

}  // namespace lode::delaunay_pyramid
