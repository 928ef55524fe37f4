#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/api/mesh_extraction.h"
#include "lode/api/query.h"
#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

/// Which fields of a mesh a question is about: places in TetraInfo::fields.
struct TetraFieldUse {
  std::size_t measured = 0;          ///< Whose errors and values count.
  std::vector<std::size_t> along{};  ///< Others, whose values at its vertices the answer has too.
};

struct TetraMeshOptions {
  /// As in MeshOptions, and with a view: accurate in what it shows. Without a focus, that is where
  /// the field may have a value of the threshold.
  Query query;
  /// For the best answer that is ready after so many seconds; without max_error that is 0 then.
  std::optional<double> deadline_s{};
  /// Only cells of the cut whose values lie in it everywhere, that is at all corners.
  std::optional<Range> threshold{};
  /// Only their cells, and the query counts in these alone; empty: all. The budget counts cells of
  /// all regions.
  std::vector<std::int64_t> regions{};
  /// Of boundaries: only the faces of patches of these names or numbers; empty: all.
  std::vector<std::string> patches{};
  Threads threads{};
  TetraFieldUse fields{};
};

struct TetraSurfaceOptions {
  Query query;
  std::optional<double> deadline_s{};  ///< Likewise.
  Normals normals = Normals::on;
  std::vector<std::int64_t> regions{};  ///< Likewise.
  Threads threads{};
  TetraFieldUse fields{};
};

struct TetraSectionOptions {
  std::vector<SectionPlane> planes;
  std::vector<double> isovalues;            ///< As in SectionOptions.
  std::vector<Range> field_ranges;          ///< Likewise.
  std::optional<double> max_error{};        ///< Likewise.
  std::optional<double> max_world_error{};  ///< Query's.
  Budget budget{};
  std::optional<double> deadline_s{};
  std::vector<std::int64_t> regions{};
  TetraFieldUse fields{};
};

/// Of isosurfaces, sections and boundaries of meshes of tetrahedra.
struct TetraSurfaceReport {
  double max_error = 0;       ///< The tolerance asked for (or chosen), field units.
  double achieved_error = 0;  ///< Largest error of a cell that the surface comes from.
  std::optional<double> achieved_world_error{};  ///< MeshReport's, of the whole cut,
  std::optional<double> achieved_px{};           ///< likewise.
  std::uint64_t n_triangles = 0;
  std::uint64_t n_lines = 0;
  std::uint64_t n_vertices = 0;
  std::uint64_t n_cut_cells = 0;
  std::uint64_t n_left_out = 0;  ///< Cells of the cut that threshold or regions leave out.
  std::vector<double> unmet{};   ///< Isovalues that nothing of the answer has.
  bool budget_met = true;
  bool is_settled = true;  ///< False: the deadline ended refinement.
  double seconds = 0;
};

/// Refuses planes that are none.
[[nodiscard]] Result<void> check_planes(std::span<const SectionPlane> planes);

/// With the foci that the options stand for.
[[nodiscard]] Query query_of(const TetraMeshOptions& options);
[[nodiscard]] Query query_of(const TetraSectionOptions& options);

/// The mesh of a cut, and what makes surfaces of all cuts alike.
struct TetraCutMesh {
  SimplexMesh mesh{};
  std::vector<std::uint32_t> vertex_ids{};  ///< The hierarchy's numbers of its vertices.
  std::vector<Vec3f> gradients{};           ///< By vertex, for normals; empty: none.
  Vec3d origin{};                           ///< What positions of surfaces are relative to.
  double margin = 0;                        ///< rounding_margin() of the reference mesh.
  MeshReport report{};                      ///< Of tolerance and budget; other counts are to come.
};

/// Leaves out what the options' threshold does, and fills in the report's counts and largest error.
void apply_threshold(const TetraMeshOptions& options, TetraCutMesh& cut);

/// What TetraDataset makes of it, in place of what `surface` holds; seconds are not filled in.
[[nodiscard]] TetraSurfaceReport make_isosurfaces(const TetraCutMesh& cut,
                                                  const TetraSurfaceOptions& options,
                                                  Surface& surface);
[[nodiscard]] TetraSurfaceReport make_sections(const TetraCutMesh& cut,
                                               const TetraSectionOptions& options,
                                               Surface& surface);
/// `patches`: places; empty: all faces.
[[nodiscard]] TetraSurfaceReport make_boundary(const TetraCutMesh& cut,
                                               std::span<const std::uint32_t> patches,
                                               Threads threads, Surface& surface);

}  // namespace lode
