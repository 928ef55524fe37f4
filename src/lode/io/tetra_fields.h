#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/split_cells.h"
#include "lode/io/tetrahedra.h"

namespace lode::io {

/// Fields of one component each, as the options choose them.
struct ChosenFields {
  /// In the order in which they are wanted; those of cells have their values below, by name.
  std::vector<MeshField> fields;
  std::vector<std::uint8_t>
      is_of_cells;  ///< By field: whether its values are still those of cells.
  std::vector<MagnitudeField> magnitudes;
};

/// Fails on a name that the mesh lacks, on components that a field lacks, and on a name twice.
[[nodiscard]] Result<ChosenFields> choose_fields(const CellMesh& mesh, const TetraOptions& options);

/// Values of cells become values of the mesh's points: means over the cells at each, weighted by
/// volume; where these have none, or infinite ones, unweighted. NaN at points of no cell. Cells of
/// all regions count alike; `regions`, find_regions(), is for what is reported.
void average_cells(const CellMesh& mesh, std::size_t regions, const SplitCells& split,
                   ChosenFields& chosen, TetraReport& report);

}  // namespace lode::io
