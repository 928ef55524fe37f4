#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/probe.h"
#include "lode/api/tetra_extraction.h"
#include "lode/api/verify_report.h"
#include "lode/core/box.h"
#include "lode/core/mesh.h"
#include "lode/core/mesh_region.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/core/surface.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/build_record.h"
#include "lode/models/tetra_mt/collapse_order.h"

namespace lode {

using tetra_mt::CollapseOrder;
using TetraBuildRecord = tetra_mt::BuildRecord;

/// Where edges collapse to: one of their ends, so that all vertices are the reference's with their
/// own values; or, as in the paper, their midpoints.
enum class Placement : std::uint8_t { half_edge, midpoint };

struct TetraBuildOptions {
  /// Of the cells, how many are left in the base; more where none may go.
  double base_share = 0.01;
  /// How far the boundary, and what lies between regions, may move; the mesh's unit. 0: they stay
  /// in their planes (CollapseRules::boundary_tolerance).
  double boundary_tolerance = 0;
  /// Extrema of the fields on the mesh itself stay, too, not only those of the mesh as it is when
  /// an edge collapses; of half edges.
  bool keeps_extrema = false;
  /// Whether world errors are found, too: how far points of the same value may lie apart, the
  /// paper's space error, an estimate (CollapseFacts). Queries with Query::max_world_error or
  /// max_error_px need them; a byte a vertex and field.
  bool has_world_errors = false;
  /// Of half edges in files, whether these leave out what queries do without: gradients, of which
  /// normals come, which then are those of the cut, and the mesh's numbers of vertices, which
  /// attach_fields() takes.
  bool is_lean = false;
  /// Where errors hold. Everywhere takes a few times as long, and a boundary_tolerance of 0.
  ErrorPlace error_place = ErrorPlace::at_samples;
  /// Midpoints have errors at samples.
  Placement placement = Placement::half_edge;
  /// Which edges collapse first. Errors are measured, and as true, whatever it is: quadrics take
  /// less time where most cells go, for larger errors at as many.
  CollapseOrder order = CollapseOrder::squared_error;
  /// Of all its fields, where they are a step of a series, in any unit; finite. Others come later,
  /// by attach_fields().
  std::optional<double> time{};
  /// What was counted when the mesh was read, and what was said of its arrays, by name: for whoever
  /// opens the file, TetraInfo::record.
  std::vector<TetraBuildRecord::Count> reading{};
  std::vector<TetraBuildRecord::Note> notes{};
  /// Bytes; a mesh that needs more is refused. 0: none.
  std::uint64_t memory_limit = 0;
  Threads threads{};
};

/// What building takes at most, with the mesh itself: 200 bytes a tetrahedron of a mesh with one
/// field, 240 where errors hold everywhere, and 80 a vertex for each further
/// field; more in the order of quadrics, of midpoints, and with world errors.
[[nodiscard]] std::uint64_t memory_to_build(const TetraMesh& mesh,
                                            const TetraBuildOptions& options);

struct TetraVerifyOptions {
  std::uint32_t n_random_cuts = 8;  ///< The first is the base.
  std::uint64_t seed = 1;           ///< Of their nodes, and of the order in which all are applied.
  /// Errors at all points of these, too, by the overlay with the reference mesh: takes long.
  bool is_exact = false;
  std::vector<std::size_t> fields{};  ///< Whose errors and ranges are checked; empty: all.
  Threads threads{};
};

struct TetraFieldInfo {
  std::string name;
  ScalarType type = ScalarType::float64;
  double range_min = 0;  ///< Both 0 where there is no vertex.
  double range_max = 0;
  ErrorPlace error_place = ErrorPlace::at_samples;  ///< Of all its errors.
  double base_error = 0;                            ///< Largest |F - F'| on the base.
  std::optional<double> time{};                     ///< Of a series.
  /// Largest world error of a node that the base's cells wait for; none where it has none.
  std::optional<double> base_world_error{};
};

struct TetraInfo {
  Placement placement = Placement::half_edge;
  std::uint64_t n_vertices = 0;  ///< Of the reference mesh.
  std::uint64_t n_cells = 0;
  std::uint64_t n_base_cells = 0;
  std::uint64_t n_nodes = 0;             ///< Collapses, and splits that undo them.
  std::vector<TetraFieldInfo> fields{};  ///< At least one.
  Box3d bounds{};                        ///< Of all vertices.
  double boundary_deviation = 0;         ///< Of cuts' boundaries; the mesh's unit.
  TetraBuildRecord record{};             ///< What its build was told, and what came of it.
  bool is_lean = false;                  ///< A file's: TetraBuildOptions::is_lean.
  std::vector<MeshRegion> regions{};     ///< By number, ascending.
  std::vector<BoundaryPatch> patches{};  ///< Parts of the boundary, likewise.
};

/// What has been read of a file since it was opened; nothing in memory.
struct TetraReads {
  std::uint64_t n_bytes = 0;
  std::uint64_t file_size = 0;
};

struct TetraFileReport {
  TetraInfo info;
  std::uint64_t file_bytes = 0;
  double build_seconds = 0;
  double write_seconds = 0;
};

/// The door of tetrahedral meshes with fields: a Multi-Tessellation of half-edge collapses, or of
/// edges to their midpoints (docs/models/tetra_mt.md), in memory or in a file, of which parts are
/// read when queries ask for them. F is linear on each tetrahedron of the reference mesh. Errors
/// hold at samples, the reference's vertices, between which F' may be farther off; or everywhere,
/// where the hierarchy was built so.
class TetraDataset {
 public:
  /// `mesh`: with fields, at least one, of finite values. Edges collapse by the sum of squared
  /// errors of all, as shares of their ranges; extrema of each stay.
  [[nodiscard]] static Result<TetraDataset> build(const TetraMesh& mesh,
                                                  const TetraBuildOptions& options,
                                                  Progress& progress);
  /// Writes what build() makes to a .lode file, whole or not at all.
  [[nodiscard]] static Result<TetraFileReport> build_file(const TetraMesh& mesh,
                                                          const std::string& path,
                                                          const TetraBuildOptions& options,
                                                          Progress& progress);
  /// Whether a file is a .lode file of this model; also false where it cannot be read.
  [[nodiscard]] static bool is_model_of(const std::string& path);
  /// Of a .lode file; reads its base.
  [[nodiscard]] static Result<TetraDataset> open(const std::string& path);
  TetraDataset(TetraDataset&&) noexcept;
  TetraDataset& operator=(TetraDataset&&) noexcept;
  ~TetraDataset();

  [[nodiscard]] const TetraInfo& describe() const;
  [[nodiscard]] TetraReads reads() const;
  // Questions that follow one another are TetraSession's.

  /// The mesh of a query's cut, with its fields and by cell the error; conforming, its
  /// vertices the reference's. Without max_error as for volumes. With a
  /// threshold only some of its cells, and report.n_left_out says how many are not there.
  [[nodiscard]] Result<MeshReport> extract_mesh(const TetraMeshOptions& options, SimplexMesh& mesh,
                                                Progress& progress) const;
  /// The isosurfaces of the query's isovalues on the mesh of its cut: what add_isosurface() makes.
  /// Crack-free; they end at the mesh's boundary. At a max_error of 0 those of the reference mesh,
  /// triangle by triangle. Normals come from vertex_gradients() of the reference mesh, whatever the
  /// cut: found when they are first asked for, and kept, 12 bytes a vertex.
  [[nodiscard]] Result<TetraSurfaceReport> extract_surface(const TetraSurfaceOptions& options,
                                                           Surface& surface,
                                                           Progress& progress) const;
  /// What planes cut out of the mesh of a query that is fine along them, one after the other: what
  /// cut_section() makes, or with isovalues the lines on it. At a max_error of 0 what they cut out
  /// of the reference mesh.
  [[nodiscard]] Result<TetraSurfaceReport> extract_section(const TetraSectionOptions& options,
                                                           Surface& surface,
                                                           Progress& progress) const;
  /// The outer faces of what extract_mesh() makes: mesh_boundary().
  [[nodiscard]] Result<TetraSurfaceReport> extract_boundary(const TetraMeshOptions& options,
                                                            Surface& surface,
                                                            Progress& progress) const;
  /// F' of a cut that is accurate at these points, one answer each, and proven bounds of F: at a
  /// max_error of 0 those of rounding. Of a file little more is read than is near them.
  [[nodiscard]] Result<ProbeReport> probe(std::span<const Vec3d> points,
                                          const ProbeOptions& options,
                                          std::vector<ProbedPoint>& found,
                                          Progress& progress) const;
  /// The same along a line.
  [[nodiscard]] Result<ProbeReport> probe_line(const ProbedLine& line, const ProbeOptions& options,
                                               std::vector<ProbedLinePoint>& found,
                                               Progress& progress) const;
  /// Volume, integral, mean and extremes over the domain, or what of it is in a box and in regions.
  [[nodiscard]] Result<IntegralReport> integrate(const IntegralOptions& options,
                                                 Progress& progress) const;
  /// What verify_hierarchy() finds.
  [[nodiscard]] Result<VerifyReport> verify(const TetraVerifyOptions& options,
                                            Progress& progress) const;
  /// What compare_with_original() finds. `fields`: places of those that the original has.
  [[nodiscard]] Result<VerifyReport> verify_against(const TetraMesh& original,
                                                    std::span<const std::size_t> fields,
                                                    Progress& progress) const;

 private:
  class Impl;
  friend class TetraSession;
  explicit TetraDataset(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The place of a field. `name`: empty for the first of those at the time; `time`: none for those
/// without, and for the first time where all have one. Fails where there is none, and says which
/// there are.
[[nodiscard]] Result<std::size_t> find_field(const TetraInfo& info, const std::string& name,
                                             const std::optional<double>& time = {});
/// Numbers of regions, of which each text names some by their name, or one by its number. Fails
/// where there is none, and says which there are.
[[nodiscard]] Result<std::vector<std::int64_t>> find_regions(const TetraInfo& info,
                                                             std::span<const std::string> wanted);
/// Places of the fields that are known at a field's time: of that time, and those without one; not
/// of the field itself.
[[nodiscard]] std::vector<std::size_t> fields_along(const TetraInfo& info, std::size_t field);

}  // namespace lode
