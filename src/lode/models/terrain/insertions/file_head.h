#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/terrain/insertions/file_layout.h"
#include "lode/models/terrain/insertions/page.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/store/reader.h"

namespace lode::insertions {

/// What the metadata say that is not of the history itself.
struct FileHead {
  std::uint32_t n_base_vertices = 0;
  std::uint32_t n_base_triangles = 0;
  std::uint32_t n_nodes = 0;
  std::uint32_t n_triangles = 0;  ///< That there ever were.
  HeightType type = HeightType::float64;
  std::uint32_t n_lines = 0;
  std::uint32_t n_steps = 0;
  std::vector<Band> bands;
};

/// Fails, naming the file, on what docs/format.md does not allow. Fills in what the metadata know
/// of the history, and its levels.
[[nodiscard]] Result<FileHead> read_head(const store::Reader& reader, LevelledHistory& levelled);

/// Reads the base and its fixed edges into a history that knows its model and raster: vertices,
/// heights, triangles with errors. Fails, naming the file, where it is no triangulation of a part
/// of the plane, or not Delaunay where that is the rule.
[[nodiscard]] Result<void> read_base(const store::Reader& reader, const FileHead& head,
                                     History& history);

/// From the upper half of a float; negative where that is no error.
[[nodiscard]] float to_error(std::uint16_t upper_half);

}  // namespace lode::insertions
