#pragma once

#include <string>

#include "input.h"
#include "text.h"

namespace lode::cli {

/// A mesh of cells ready for queries, and what came of the file's cells.
struct TetraInput {
  TetraDataset dataset;
  TetraReport report;
  double seconds = 0;  ///< Reading and building.
};

/// Refuses options of reading that meshes of cells do not have.
[[nodiscard]] Result<void> check_tetra_reading(const ReadingArguments& reading,
                                               const std::string& path);

/// Builds the hierarchy of a file's cells in memory and says so on stderr; warns of regions.
[[nodiscard]] Result<TetraInput> build_tetra_input(const std::string& path,
                                                   const ReadingArguments& reading,
                                                   Session& session);

/// What was made of the file's cells, as far as a user may wonder at it.
void add_cell_counts(const TetraReport& report, Table& table, Json& json);

}  // namespace lode::cli
