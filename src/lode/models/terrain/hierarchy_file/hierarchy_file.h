#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/terrain_file/source.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/store/reader.h"

namespace lode::hierarchy_file {

/// How triangles are refined.
enum class Kind : std::uint8_t { adaptive_triangulation, hierarchical_delaunay };

/// A hierarchy with what it remembers of the raster or points that it is of.
struct HierarchyModel {
  terrain_file::Source source;
  Kind kind = Kind::adaptive_triangulation;
  triangle_hierarchy::Hierarchy hierarchy;  ///< Its frame is the source's, and its kind of samples.
};

/// What is known of a hierarchy before its vertices and triangles are: of levels, how many there
/// are of each until them, those with them.
struct Head {
  terrain_file::Source source;
  Kind kind = Kind::adaptive_triangulation;
  std::vector<double> tolerances;
  int bits = 0;
  std::int32_t reach = 0;
  std::uint32_t n_lines = 0;
  std::uint32_t n_crowded = 0;
  std::vector<std::uint32_t> vertices_until;
  std::vector<std::uint32_t> triangles_until;
  std::vector<std::uint32_t> refinements_until;

  [[nodiscard]] int n_levels() const { return static_cast<int>(tolerances.size()); }
  /// Triangles in the mesh of a level.
  [[nodiscard]] std::uint64_t n_triangles_in(int level) const {
    const auto i = static_cast<std::size_t>(level);
    return triangles_until[i] - refinements_until[i];
  }
  /// Of the whole hierarchy in memory.
  [[nodiscard]] std::uint64_t n_bytes() const;
};

[[nodiscard]] Head head_of(const HierarchyModel& model);

/// Writes all vertices, triangles and refinements, as docs/format.md says, whole or not at all;
/// twins are left out. Returns the size of the file.
[[nodiscard]] Result<std::uint64_t> save(const HierarchyModel& model, const std::string& path,
                                         Progress& progress);

/// A file whose levels are read when they are wanted: of its columns, which are in the order of
/// levels, as much as these take.
class HierarchyFile {
 public:
  /// Reads what it says of itself.
  [[nodiscard]] static Result<HierarchyFile> open(const std::string& path);

  [[nodiscard]] const Head& head() const { return head_; }

  /// The first levels, at least one, as if there were no others, with twins. Fails on all that is
  /// not as docs/format.md says, naming the file and what was expected. Of what was read is known
  /// that
  /// - triangles turn left, and refinements are a forest by levels;
  /// - the mesh of each level has two triangles at each edge but at those of its outline, which of
  ///   a raster runs along columns and rows, is that of level 0, and goes round each place once at
  ///   most: so the mesh covers what is inside once, without overlaps and cracks;
  /// - triangles say that they keep the tolerances of the levels whose meshes they are in.
  /// Heights, errors, and that lines are edges, are not found again: that is for verification.
  /// O(n log n) for each level and its n triangles.
  [[nodiscard]] Result<HierarchyModel> read(int n_levels, Progress& progress) const;

 private:
  HierarchyFile(store::Reader reader, Head head);

  store::Reader reader_;
  Head head_;
};

/// All levels of a file.
[[nodiscard]] Result<HierarchyModel> open(const std::string& path, Progress& progress);

}  // namespace lode::hierarchy_file
