#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/terrain_file/source.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"

namespace lode::hierarchy_file {

/// How triangles are refined.
enum class Kind : std::uint8_t { adaptive_triangulation, hierarchical_delaunay };

/// A hierarchy with what it remembers of the raster that it is of.
struct HierarchyModel {
  terrain_file::Source source;
  Kind kind = Kind::adaptive_triangulation;
  triangle_hierarchy::Hierarchy hierarchy;  ///< Its frame is the source's.
};

/// The model's name in files: that of the room that made it.
[[nodiscard]] std::string_view model_name(const HierarchyModel& model);

/// Writes all vertices, triangles and refinements, as docs/format.md says, whole or not at all;
/// twins are left out. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const HierarchyModel& model, const std::string& path,
                                         Progress& progress);

/// Whether a file is a .lode file of these models; also false where it cannot be read.
[[nodiscard]] bool is_model_of(const std::string& path);

/// Reads all of it, and finds twins again. Fails on all that is not as docs/format.md says, naming
/// the file and what was expected. Of what was opened is known that
/// - triangles turn left, and refinements are a forest by levels;
/// - the mesh of each level has two triangles at each edge but at those of its outline, which runs
///   along columns and rows, is that of level 0, and goes round each place once at most: so the
///   mesh covers what is inside once, without overlaps and cracks;
/// - triangles say that they keep the tolerances of the levels whose meshes they are in.
/// Heights, errors, and that lines are edges, are not found again: that is for verification. O(n
/// log n) for each level and its n triangles.
[[nodiscard]] Result<HierarchyModel> open(const std::string& path, Progress& progress);

}  // namespace lode::hierarchy_file
