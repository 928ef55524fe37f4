#pragma once

#include "input.h"
#include "text.h"

namespace lode::cli {

/// Adds what became of lines, where there are some.
void add_lines(const OpenedTerrain& opened, Json& json, Table& table);

/// The keys and rows of a terrain: size, CRS, unit, samples that are missing.
void add_facts(const TerrainFacts& facts, Json& json, Table& table);

/// Between which x and y there are samples or points, how far apart the samples are, and what the
/// file says that its pixels are: what --at, --box and --clip go by. Fails as read_metric() does.
[[nodiscard]] Result<void> add_extent(const TerrainFacts& facts, Json& json, Table& table);

/// Triangles of all samples: two for each cell, and of points fewer than two for each.
[[nodiscard]] std::uint64_t n_full_triangles(const TerrainFacts& facts, std::uint64_t n_samples);

}  // namespace lode::cli
