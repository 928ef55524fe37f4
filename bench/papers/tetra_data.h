#pragma once

#include <cstdint>
#include <string>

#include "bench/tetra_cases.h"
#include "lode/api/tetra_dataset.h"
#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode::bench {

inline constexpr Threads kTableThreads{2};  ///< Of what is not timed on one.
inline constexpr double kTableBaseShare = 0.01;

/// A data set of the tables that stand beside the paper's on tetrahedra, and what is made of it
/// once.
struct TetraData {
  std::string name;
  TetraMesh mesh;
  SimplexMesh cells;  ///< The mesh.
  double low = 0;     ///< Of the field.
  double high = 0;
  tetra_mt::PackedHierarchy hierarchy;
  TetraDataset dataset;  ///< The same.
  double build_s = 0;
  double margin = 0;  ///< Of isosurfaces.

  [[nodiscard]] double range() const { return high - low; }
  /// Percent of the mesh's.
  [[nodiscard]] double share(std::uint64_t n_cells) const {
    return 100 * static_cast<double>(n_cells) / static_cast<double>(mesh.tetrahedra.size());
  }
};

/// Fails as load() does.
[[nodiscard]] Result<TetraData> prepare(const TetraCase& tetra_case);

/// With a digit behind the point, of a table.
[[nodiscard]] std::string milliseconds(double seconds);

}  // namespace lode::bench
