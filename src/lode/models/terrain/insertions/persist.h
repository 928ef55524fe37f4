#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// The model's name in files, as that of the enumerator.
[[nodiscard]] std::string_view model_name(Model model);

/// The mesh of a level.
struct LevelFacts {
  double tolerance = 0;  ///< Of an implicit pyramid what the level keeps.
  std::uint32_t n_triangles = 0;
  std::uint32_t n_vertices = 0;
  double smallest_angle = 0;  ///< Degrees, in the raster's coordinates.
  double median_angle = 0;    ///< Of smallest angles.

  friend bool operator==(const LevelFacts&, const LevelFacts&) = default;
};

/// A history, and the tolerances that it was made for: each finer than the one before; of an
/// implicit pyramid none.
struct LevelledHistory {
  History history;
  std::vector<double> levels;
  /// Of each level, or of an implicit pyramid of each end of one; empty: not known yet.
  std::vector<LevelFacts> facts{};
};

/// The most nodes of a page, and about those of the first band.
struct PageSize {
  std::uint32_t n_nodes = 1024;  ///< Takes about 10 kB; decision 0064 has others.
};

/// What the facts are; fails when cancelled.
[[nodiscard]] Result<std::vector<LevelFacts>> find_facts(const LevelledHistory& levelled,
                                                         Progress& progress);

/// Writes it as docs/format.md says, whole or not at all. No triangle but the base's is in
/// the file: the vertices in their order make them again. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const LevelledHistory& levelled, const std::string& path,
                                         Progress& progress, PageSize page_size = {});

/// Reads all of it and inserts the vertices again, with exact predicates: whatever the file says,
/// they make a triangulation, Delaunay where that is the rule. Fails on all that is not as
/// docs/format.md says, naming the file and what was expected. HistoryFile reads parts.
[[nodiscard]] Result<LevelledHistory> open(const std::string& path, Progress& progress);

}  // namespace lode::insertions
