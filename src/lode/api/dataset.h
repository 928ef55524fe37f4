#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/api/verify_report.h"
#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/core/surface_sink.h"
#include "lode/core/volume.h"
#include "lode/mappers/simplify_surface.h"

namespace lode {

struct BuildOptions {
  Threads threads{};
};

/// One level of the hierarchy, finest (0) first.
struct LevelInfo {
  int level = 0;
  std::int64_t step = 1;        ///< Distance of the level's samples, in samples of the data.
  std::uint64_t n_samples = 0;  ///< Samples this level adds.
  std::uint64_t n_nodes = 0;    ///< Nodes (diamonds) of this level.
  std::uint64_t bytes = 0;      ///< On disk; 0 when the dataset is not on disk.
  double max_error = 0;         ///< Largest nested error of the level's nodes, field units.
};

struct DatasetInfo {
  std::string model;  ///< "diamond2d" or "diamond3d".
  VolumeInfo volume;
  double range_min = 0;  ///< Of the finite, non-hole samples; both 0 when none is.
  double range_max = 0;
  std::uint64_t n_holes = 0;          ///< Samples that are non-finite or nodata.
  std::uint64_t n_removed_cells = 0;  ///< Unit cells the holes remove.
  double base_error = 0;              ///< Nested error of the unrefined base mesh, field units.
  std::uint64_t data_bytes = 0;       ///< Compressed samples on disk.
  std::uint64_t attribute_bytes = 0;  ///< Everything on disk that is not samples.
  std::vector<LevelInfo> levels;
};

/// How far apart numbers are that surfaces have for coordinates, in steps of the grid: of
/// float32 where they are counted from, or of float64 in the world, whichever is more.
[[nodiscard]] double coordinate_step(const RegularGrid& grid);

/// Blocks of a file, and all bytes, header and directory included; what is read twice counts twice.
struct FileReads {
  std::uint64_t blocks = 0;
  std::uint64_t bytes = 0;
};

enum class Normals : std::uint8_t { off, on };
/// Whether the report of a surface in the style of cubes says how far it is from the level set,
/// which takes about a microsecond for each cell that it crosses.
enum class Deviation : std::uint8_t { unknown, measured };
/// Which edges of a surface collapse; slivers: those up to simplify_distance long.
enum class Simplify : std::uint8_t { off, edges, slivers };
enum class Orientation : std::uint8_t { from_lower_values, from_higher_values };
/// closed: caps in the border planes make the surface the whole boundary of the region at or above
/// the isovalue (one isovalue, no clip box, no holes at the border; it stays open at other holes).
enum class Border : std::uint8_t { open, closed };

struct ExtractOptions {
  std::vector<double> isovalues;  ///< At least one; finite, each once.
  /// Field units, >= 0; unset: 0.5 % of the value range, or none where there is a max_distance.
  std::optional<double> max_error{};
  /// World units, > 0: no point of the surface is farther from that of full resolution, nor any of
  /// that one from it, proven. Of volumes, with an open border and all pieces kept. Of files larger
  /// than the memory limit in windows, for whose triangles half of it is taken beside, and a
  /// quarter for the nodes that it takes: another limit gives another surface, as near.
  std::optional<double> max_distance{};
  /// 0: the surface has the components, tunnels and voids of that of full resolution, each joined
  /// as there: it is that surface but for where it lies. P > 0 (field units): those at least that
  /// there are from P below the isovalue to P above it. Pieces round regions of either side that
  /// have no sample farther than P from it are then left out, be they beyond the max_error, until
  /// there are none: but not within a max_distance. Simplified within a max_error P is that at
  /// most; of tetrahedra within a simplify_distance, too, none are left out. Of volumes, unclipped,
  /// with all pieces kept; of files larger than the memory limit a quarter of it may be taken
  /// beside, for nodes.
  std::optional<double> keep_topology{};
  bool leaves_out_weak = true;  ///< Whether pieces are so left out.
  /// cubes, of volumes: full resolution; where the style error would be larger than the
  /// max_error, and in bricks of 32^3 cells that holes touch, tetrahedra stay. A max_error of 0
  /// is no bound.
  SurfaceStyle style = SurfaceStyle::tetra;
  /// Of cubes, world units, > 0: cells whose cube and tetrahedra are not within this of each other,
  /// both ways, keep their tetrahedra, too.
  std::optional<double> style_distance{};
  Deviation deviation = Deviation::unknown;
  std::optional<Box3d> clip{};  ///< Crops the result, world units.
  Border border = Border::open;
  std::uint64_t min_component = 0;  ///< Pieces with fewer triangles (lines) are dropped.
  /// Of a volume's surface with an open border: edges collapse within max_error, where that is not
  /// 0, and within simplify_distance, where there is one; see simplify_surface().
  /// - Within max_error: |F - isovalue| is at most that on all triangles, F being the field at full
  ///   resolution, and what is farther from the isovalue keeps its side of the surface. The surface
  ///   before is extracted within half of it. Without a simplify_distance and keep_topology closed
  ///   components that hold nothing farther go. Of one isovalue, without a clip box.
  /// - Within simplify_distance (world units, > 0): no point of the surface, or of full resolution,
  ///   is farther from the other (of cubes, and with a persistence that leaves pieces out: from the
  ///   surface before). Within both the surface before is extracted within half of each. From two
  ///   steps of the grid on, or from one where enough cells are near, at full resolution of one
  ///   isovalue, unclipped and with all pieces, a fifth goes to beginning with cubes where they are
  ///   that near.
  /// Of one isovalue, in a grid whose axes are the world's, it goes piece by piece where the model
  /// is larger than the memory limit; the surface before is then that of full resolution, or cubes.
  Simplify simplify = Simplify::off;
  std::optional<double> simplify_distance{};
  Orientation orientation = Orientation::from_lower_values;  ///< Which side sees triangles ccw.
  Normals normals = Normals::on;
  Threads threads{};
  /// Bytes that the hierarchy may take, the surface aside; 0: a quarter of the machine's memory. Of
  /// an opened file more than that is not loaded, where the query can do without; vertices and
  /// triangles of tolerance 0, and only those, then come in another order. Where
  /// the limit is less than one chunk of 256^3 samples and the coarse levels take, extract() fails
  /// and says what is needed.
  std::uint64_t memory_limit = 0;
};

/// Seconds per phase of an extraction.
struct ExtractSeconds {
  double total = 0;
  double select = 0;    ///< Finding the active simplices.
  double geometry = 0;  ///< Vertices, triangles, stitching.
  double finish = 0;    ///< Normals, clipping, caps, small pieces.
  double measure = 0;   ///< How far cubes are from the level set.
  double topology = 0;  ///< Finding critical nodes.
  double distance = 0;  ///< Finding the cut that keeps max_distance.
  double simplify = 0;
  double write = 0;  ///< Of a file; not part of the total.
};

/// How the topology was kept; of several isovalues sums.
struct KeptTopology {
  double persistence = 0;          ///< Asked for; simplified within an error that at most.
  bool is_searched = true;         ///< Not where all is refined, at a max_error of 0 or of cubes.
  bool leaves_out_weak = false;    ///< See ExtractOptions::keep_topology.
  std::uint64_t weak_regions = 0;  ///< That were left out so.
  /// Refining one changes the topology; but at the domain's border also some that reach across
  /// it, which are refined for that anyway, are counted. With a persistence those alone that
  /// neither the tolerance nor other isovalues refine.
  std::uint64_t critical_nodes = 0;
  std::uint64_t nodes = 0;  ///< With those that come before them, each once.
};

/// How max_distance was kept; of several isovalues sums, and the largest distances.
struct DistanceReport {
  double max_distance = 0;           ///< Asked for, world units.
  double proven_distance = 0;        ///< Of any point of the surface, or of full resolution's, from
                                     ///< the other, lost parts aside; <= max_distance.
  std::uint64_t rounds = 0;          ///< How often the surface was held against the other.
  std::uint64_t nodes_refined = 0;   ///< For the distance.
  std::uint64_t full_triangles = 0;  ///< Of full resolution's surface.
  std::uint64_t lost_triangles = 0;  ///< Of them, those without any surface near,
  double lost_size = 0;              ///< and the diagonal of the box round them, world units.
  std::uint64_t memory_limit = 0;    ///< That windows were made for; 0: all in memory.
};

struct ExtractReport {
  /// The tolerance asked for (or chosen), field units; infinite where only a distance was.
  double max_error = 0;
  double achieved_error = 0;  ///< Proven bound of |F - F'| over the active simplices, <= max_error.
  double coordinate_slack = 0;  ///< What rounding vertices may add to |F - isovalue|, field units.
  double style_error = 0;       ///< Of cubes, measured: largest |F - isovalue|, field units,
  double style_distance = 0;    ///< and how far at most from F = isovalue, world units.
  std::uint64_t triangles = 0;
  std::uint64_t lines = 0;
  std::uint64_t vertices = 0;
  std::uint64_t nodes_visited = 0;
  std::uint64_t cap_cells = 0;           ///< Triangles (lines) that close the border.
  std::uint64_t open_edges = 0;          ///< With a closed border: edges at holes, still open.
  std::uint64_t components_dropped = 0;  ///< By min_component.
  std::uint64_t triangles_dropped = 0;   ///< Their triangles (lines).
  /// Errors and distances above are those of the surface before it.
  std::optional<SimplifyReport> simplified;
  std::optional<DistanceReport> distance;
  std::optional<KeptTopology> topology;
  std::uint64_t bytes_read = 0;   ///< Of the file, for this query; 0 from memory.
  std::uint64_t blocks_read = 0;  ///< Likewise.
  std::vector<double> unmet;      ///< Isovalues without any surface.
  ExtractSeconds seconds;
};

struct CountOptions {
  std::vector<double> isovalues;      ///< At least one; finite; in any order.
  std::optional<double> max_error{};  ///< As in ExtractOptions.
  Threads threads{};
  /// As in ExtractOptions. What may not be loaded is counted chunk by chunk, one isovalue after the
  /// other.
  std::uint64_t memory_limit = 0;
};

/// The size of one isovalue's surface.
struct IsovalueCount {
  double isovalue = 0;
  std::uint64_t triangles = 0;
  std::uint64_t lines = 0;  ///< Of 2D data.
  std::uint64_t vertices = 0;
};

struct CountReport {
  double max_error = 0;               ///< The tolerance asked for (or chosen), field units.
  std::vector<IsovalueCount> counts;  ///< One for each isovalue, in the order of the options.
  double seconds = 0;
};

struct SalvageReport;
struct MeshOptions;
struct MeshReport;
struct SectionOptions;
struct SectionReport;
struct SimplexMesh;
struct ProbeOptions;
struct ProbedPoint;
struct ProbedLine;
struct ProbedLinePoint;
struct ProbeReport;
struct IntegralOptions;
struct IntegralReport;

/// The one door: a multiresolution model, in memory or opened from a .lode file.
/// What a surface is held to, whatever made it.
struct BoundOptions {
  double isovalue = 0;
  double error = 0;  ///< Largest |F - isovalue|, field units.
  /// World units; where there are some, only what is in one of them counts.
  std::vector<Box3d> boxes{};
  Threads threads{};
};

class Dataset {
 public:
  Dataset(Dataset&&) noexcept;
  Dataset& operator=(Dataset&&) noexcept;
  ~Dataset();

  /// Builds the hierarchy of a volume with proven errors and ranges.
  [[nodiscard]] static Result<Dataset> build(VolumeSource& source, const BuildOptions& options,
                                             Progress& progress);
  /// Opens a .lode file without reading its blocks. Live queries and sessions read what they need,
  /// when they need it, and so does extract(); everything else loads the whole file first, once.
  /// Each block that is read is checked. `threads`: for loading.
  [[nodiscard]] static Result<Dataset> open(const std::string& path, Threads threads);
  /// Opens a .lode file some of whose blocks are damaged, and loads it: what is lost is filled from
  /// coarser samples, within proven bounds. Bytes may be missing between header and directory; or
  /// the end of the file, or these two, where the first index of blocks is whole. See salvage.h.
  [[nodiscard]] static Result<Dataset> salvage(const std::string& path, Threads threads,
                                               Progress& progress);
  /// What was lost of it; null unless salvage() opened it.
  [[nodiscard]] const SalvageReport* salvaged() const;
  /// Loads what is still in the file.
  [[nodiscard]] Result<void> load(Progress& progress) const;
  /// Writes the .lode file, whole or not at all.
  [[nodiscard]] Result<void> save(const std::string& path, Threads threads,
                                  Progress& progress) const;

  [[nodiscard]] DatasetInfo describe() const;
  /// What has been read of the file since it was opened, by whatever asked; 0 of a built model.
  [[nodiscard]] FileReads reads() const;

  /// Extracts isosurfaces (or contour lines of 2D data) into `surface`, whose memory is reused.
  [[nodiscard]] Result<ExtractReport> extract(const ExtractOptions& options, Surface& surface,
                                              Progress& progress) const;
  /// The same into a sink. Where comes_in_pieces(), no more of the surface is in memory than a
  /// chunk's piece and vertices that pieces share, else the sink gets it whole. The pieces are the
  /// surface that the other extract() gives, vertex by vertex.
  [[nodiscard]] Result<ExtractReport> extract(const ExtractOptions& options, SurfaceSink& surface,
                                              Progress& progress) const;
  /// Whether the model stays in its file and no edit (clip, closed border, dropped components)
  /// needs the whole surface.
  [[nodiscard]] Result<bool> comes_in_pieces(const ExtractOptions& options,
                                             Progress& progress) const;

  /// Whether extract() takes several isovalues: not where it simplifies within a max_error.
  [[nodiscard]] bool takes_several_isovalues(const ExtractOptions& options) const;

  /// The sizes of many isovalues' surfaces in the style of tetrahedra, without making any of them:
  /// exactly what extract() gives of each alone, but for all of them in one pass.
  [[nodiscard]] Result<CountReport> count(const CountOptions& options, Progress& progress) const;

  /// The mesh of a query; see mesh_extraction.h.
  [[nodiscard]] Result<MeshReport> extract_mesh(const MeshOptions& options, SimplexMesh& mesh,
                                                Progress& progress) const;
  /// A planar section of a volume, or isolines on it; see mesh_extraction.h.
  [[nodiscard]] Result<SectionReport> extract_section(const SectionOptions& options,
                                                      Surface& section, Progress& progress) const;

  /// The field of a volume at points, in their order; see probe.h. Of a file only what is near them
  /// is read. Points beyond the data, or in cells that touch a hole, are outside.
  [[nodiscard]] Result<ProbeReport> probe(std::span<const Vec3d> points,
                                          const ProbeOptions& options,
                                          std::vector<ProbedPoint>& found,
                                          Progress& progress) const;
  /// Along a line: where it meets faces of tetrahedra, or at points at equal distances.
  [[nodiscard]] Result<ProbeReport> probe_line(const ProbedLine& line, const ProbeOptions& options,
                                               std::vector<ProbedLinePoint>& found,
                                               Progress& progress) const;
  /// Over the volume, or a box. At full resolution from the samples alone, box by box; so it is
  /// with a tolerance, too, unless the cells of its cut are few beside the samples.
  [[nodiscard]] Result<IntegralReport> integrate(const IntegralOptions& options,
                                                 Progress& progress) const;

  /// Compares samples with those of the original data, and finds errors and ranges from them by
  /// their definition. Of a file that would take more memory than a limit so (0: than the machine
  /// has) the samples alone are compared, box by box, and the report says so: verify_file() holds
  /// its errors against these.
  [[nodiscard]] Result<VerifyReport> verify_against(VolumeSource& original, Threads threads,
                                                    Progress& progress,
                                                    std::uint64_t memory_limit = 0) const;
  /// Checks a surface extracted with `options`: manifold, oriented, closed where it must be, free
  /// of self-intersections, within tolerance everywhere, and all that repeating the query makes.
  /// With a max_distance also how far it is from full resolution and back, measured to 1/16 of
  /// that, or as near as 16384 pieces of a triangle allow: with a distance far below the triangles
  /// the bounds that the report gives are farther apart. One that was simplified is no level set:
  /// its pieces are compared with those of what the query makes before, and its distance from that
  /// and back is measured likewise.
  [[nodiscard]] Result<VerifyReport> verify_surface(const Surface& surface,
                                                    const ExtractOptions& options,
                                                    Progress& progress) const;
  /// Checks a surface of any origin, as one of a focus or a budget, which no query repeats alone:
  /// manifold, consistently oriented, free of self-intersections, |F - isovalue| within the bound
  /// on it, and samples that are farther on two sides of it, whichever it faces.
  [[nodiscard]] Result<VerifyReport> verify_bound(const Surface& surface,
                                                  const BoundOptions& options,
                                                  Progress& progress) const;

  class Impl;
  /// For the door's other parts.
  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  explicit Dataset(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Reads every byte of a .lode file and checks it, and finds errors and ranges anew from its
/// samples: those stored are to be the same. Within a memory limit (0: the machine's memory) that
/// goes part by part; but for the bytes it is left out, and the report says so, where the smallest
/// part takes more.
[[nodiscard]] Result<VerifyReport> verify_file(const std::string& path, Threads threads,
                                               Progress& progress, std::uint64_t memory_limit = 0);

}  // namespace lode
