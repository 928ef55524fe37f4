#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lode/api/terrain.h"
#include "lode/api/terrain_model.h"
#include "lode/api/verify_report.h"
#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode {

class BuiltModel;
struct PointTerrain;

struct TerrainBuildOptions {
  TerrainModel model = TerrainModel::delaunay_pyramid;  ///< One of kBuiltTerrainModels.
  /// Tolerances in units of the heights, finite, >= 0, each finer than the one before; empty:
  /// default_levels(). Of an implicit pyramid, which has all samples and its own levels, they mean
  /// nothing.
  std::vector<double> levels;
  bool levels_are_shares = false;  ///< Of the range of heights, in place of their units.
  std::string sample_type{};       ///< As HeightRaster has them, to be remembered.
  bool has_place = true;
  /// Samples that every mesh has as vertices: different nodes in cells with four heights, in rows.
  /// Of models on squares.
  std::vector<LatticePoint> kept{};
  /// The raster's samples as points with features as lines (add_lines() without breaklines), which
  /// every mesh has as edges, or chains of edges. Of models that is_hierarchy(); null: none.
  std::shared_ptr<const PointTerrain> lined{};
  /// Bytes that interference links may take, of models that is_pyramid_of_levels(): they may be as
  /// many as the product of two levels' triangles.
  std::uint64_t memory_limit = std::uint64_t{8} << 30;
};

/// From a 2000th of the range of heights, doubled as long as that is below the range; 0 where there
/// is none.
[[nodiscard]] std::vector<double> default_levels(const HeightRange& range);

struct BuiltTerrainInfo {
  struct Level {
    double tolerance = 0;  ///< Of an implicit pyramid what the level keeps.
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    double smallest_angle = 0;  ///< Degrees, in the raster's coordinates.
    double median_angle = 0;    ///< Of smallest angles.
  };
  /// Of a model that is_pyramid_of_levels().
  struct Part {
    std::string name;  ///< What it is of.
    std::uint64_t memory_bytes = 0;
    std::uint64_t file_bytes = 0;  ///< Compressed; 0 where it was not opened from a file.
  };

  std::vector<Level> levels;
  std::string sample_type;
  bool has_place = true;
  std::uint64_t n_nodes = 0;           ///< Samples that were inserted, squares, or vertices.
  std::uint64_t n_base_triangles = 0;  ///< Of the outline, or of level 0; of quadtrees none.
  std::uint64_t n_triangles = 0;       ///< That there ever were; of quadtrees none.
  std::uint64_t n_links = 0;           ///< Interference links.
  std::uint64_t memory_bytes = 0;
  std::vector<Part> parts;      ///< Of which memory_bytes are the sum; or none.
  std::uint64_t n_kept = 0;     ///< Samples that are always vertices.
  std::uint64_t n_lines = 0;    ///< Edges of the coarsest mesh that are always edges, or chains.
  bool is_of_points = false;    ///< Scattered ones, or of a raster with lines.
  std::uint64_t n_samples = 0;  ///< As of TerrainReport.
  std::uint64_t n_missing = 0;
  std::uint64_t n_left_out = 0;
  HeightRange range;
  double max_error = 0;  ///< The finest that it can give: |z - z'| at every sample.
};

/// What was built of a raster, or of points, for all tolerances, or some:
/// docs/models/delaunay_pyramid.md, ternary_triangulation.md, implicit_delaunay_pyramid.md,
/// quadtrees.md, right_triangle_bisection.md and hierarchical_triangulations.md. Copies are one
/// terrain; const members are safe from many threads.
class BuiltTerrain {
 public:
  /// Fails as extract_terrain() does, and on levels that are none.
  [[nodiscard]] static Result<BuiltTerrain> build(const HeightGrid& grid,
                                                  const TerrainBuildOptions& options,
                                                  Progress& progress);
  /// The same of scattered points, or of a raster with lines: models that is_of_any_points(). Lines
  /// are edges of every mesh. Default levels and options are those of rasters.
  [[nodiscard]] static Result<BuiltTerrain> build(const PointTerrain& terrain,
                                                  const TerrainBuildOptions& options,
                                                  Progress& progress);
  /// Reads a file; of levels of triangles what it says of itself; of insertions (delaunay_pyramid,
  /// ternary_triangulation, implicit_delaunay_pyramid) what says where things are, and the base:
  /// questions read what they take. Fails on what docs/format.md does not allow; of these a
  /// question fails where it reads it.
  [[nodiscard]] static Result<BuiltTerrain> open(const std::string& path, Progress& progress);
  /// Whether a path is a .lode file of these models; also false where it cannot be read.
  [[nodiscard]] static bool is_model_of(const std::string& path);

  /// Whole or not at all. Returns the size of the file.
  [[nodiscard]] Result<std::uint64_t> save(const std::string& path, Progress& progress) const;

  /// To ask of. At tolerances finer than max_error there is no answer; with max_cells the finest
  /// mesh on the way that has no more; with a focus the fewest triangles within it.
  [[nodiscard]] Terrain terrain() const;
  [[nodiscard]] TerrainModel model() const;
  /// All heights of the raster that it is of, where the model keeps them (on squares); else null.
  [[nodiscard]] std::shared_ptr<const HeightGrid> samples() const;
  /// Of the raster, or the points' lattice.
  [[nodiscard]] const HeightFrame& frame() const;
  /// Of a file that is read as it is needed, what has been so far; else 0.
  [[nodiscard]] std::uint64_t n_bytes_read() const;
  /// Without levels.
  [[nodiscard]] BuiltTerrainInfo describe_source() const;
  /// With levels. Fails when cancelled.
  [[nodiscard]] Result<BuiltTerrainInfo> describe(Progress& progress) const;

  /// Holds it against the raster it was built of, at every level: the domain, the heights and
  /// the errors that triangles state, and Delaunay pyramids for being Delaunay, by other means than
  /// they were made.
  [[nodiscard]] Result<VerifyReport> verify(const HeightGrid& grid, Threads threads,
                                            Progress& progress) const;
  /// The same of a model of points. Fails where it is of none, as that of a raster does where it is
  /// of points. Of a model of a raster that is_hierarchy(), whether its lines are those of the
  /// raster with features, and nothing more.
  [[nodiscard]] Result<VerifyReport> verify(const PointTerrain& terrain, Threads threads,
                                            Progress& progress) const;
  /// What can be held against nothing but itself: that opening made all triangles again; of models
  /// that have all heights, as verify() with these; of pyramids of levels, that meshes are Delaunay
  /// and links to all that meets.
  [[nodiscard]] Result<VerifyReport> verify_alone(Threads threads, Progress& progress) const;

 private:
  explicit BuiltTerrain(std::shared_ptr<const BuiltModel> model);

  std::shared_ptr<const BuiltModel> model_;
};

}  // namespace lode
