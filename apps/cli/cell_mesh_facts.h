#pragma once

#include "input.h"
#include "lode/api/files.h"
#include "text.h"

namespace lode::cli {

/// What `lode info` says of a mesh of cells as its file has it: where it lies, its fields, and the
/// ranges of these, by which isovalues and thresholds are chosen.
void add_cell_mesh(const CellMesh& cells, Table& table, Json& json);

}  // namespace lode::cli
