#pragma once

#include <vector>

#include "input.h"
#include "lode/api/tetra_dataset.h"
#include "text.h"

namespace lode::cli {

// What is said of how a mesh of cells was read and its hierarchy built.

/// What was made of the file's cells, as far as a user may wonder at it.
void add_cell_counts(const TetraReport& report, Table& table, Json& json);
/// Of that, what became of the values of its fields.
[[nodiscard]] std::vector<TetraBuildRecord::Note> notes_of_fields(const TetraReport& report);
/// The same, for the file that is built.
void keep_reading(const TetraReport& report, TetraBuildOptions& options);
/// The same, as it was kept.
void add_kept_reading(const TetraBuildRecord& record, Table& table, Json& json);

/// Of what was kept, the cells that are folded over others.
[[nodiscard]] std::uint64_t kept_inverted(const TetraBuildRecord& record);

/// As --order has it.
[[nodiscard]] const char* name_of(CollapseOrder order);
/// Order, extrema, the boundary's tolerance, and what keeps the vertices of the base.
void add_record(const TetraBuildRecord& record, Table& table, Json& json);

}  // namespace lode::cli
