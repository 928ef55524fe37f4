#pragma once

#include <string>

#include "command.h"
#include "text.h"

namespace lode::cli {

/// The keys every JSON description of a volume has: dims, spacing, origin, direction, frame, ...
[[nodiscard]] Json to_json(const VolumeInfo& volume);
/// Those, and model, range, holes, levels and sizes.
[[nodiscard]] Json to_json(const DatasetInfo& info);

/// "lengths in mm, values in HU", or what of that is known; empty: nothing.
[[nodiscard]] std::string describe_units(const Units& units);
/// A row, where any is known.
void add_units(Table& table, const Units& units);
/// length_unit and value_unit; null where they are not known.
void add_units(Json& json, const Units& units);

/// Rows for dims, spacing, origin, direction, frame, units, type and field.
void add_volume(Table& table, const VolumeInfo& volume);
/// Rows for sizes on disk and bytes per sample; none for a dataset in memory.
void add_sizes(Table& table, const DatasetInfo& info);

/// "0 to 255", or "none" when every sample is a hole.
[[nodiscard]] std::string describe_range(const DatasetInfo& info);
/// The levels table, coarsest first.
[[nodiscard]] std::string describe_levels(const DatasetInfo& info);

}  // namespace lode::cli
