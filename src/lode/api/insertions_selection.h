#pragma once

#include <cstdint>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/core/stopwatch.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/persist.h"

namespace lode {

/// A model of insertions with all of its nodes.
struct FinestMesh {
  double max_error = 0;  ///< |z - z'| at every sample.
  std::uint64_t n_triangles = 0;
};

/// The tolerance of options; with a number of triangles alone 0. Fails where it, or the one outside
/// of a focus, is finer than what the model was built for, and where there are a focus and a
/// number.
[[nodiscard]] Result<double> insertions_tolerance(const TerrainOptions& options,
                                                  const HeightRange& range, double finest);

/// The mesh of one tolerance, or of a number of triangles: of a history that goes on to where that
/// is. Fills in how the report keeps them.
[[nodiscard]] delaunay::Tin uniform_tin(const insertions::History& history, double max_error,
                                        const TerrainOptions& options, double tolerance,
                                        TerrainReport& report);

/// What is left to say of a mesh with errors.
void finish_report(const terrain_file::Source& source, const FinestMesh& finest, double tolerance,
                   const Stopwatch& watch, SelectedTerrain& selected);

[[nodiscard]] TerrainModel terrain_model_of(insertions::Model model);

/// Of a history without nodes what does not depend on these.
[[nodiscard]] BuiltTerrainInfo describe_base(const insertions::History& history);
void add_levels(std::span<const insertions::LevelFacts> facts, BuiltTerrainInfo& info);

}  // namespace lode
