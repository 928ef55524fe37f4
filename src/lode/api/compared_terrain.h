#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/api/terrain_source.h"
#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/refine/focus.h"

namespace lode {

struct PointTerrain;

/// A rectangle of columns and rows, with its border.
struct TerrainWindow {
  delaunay::LatticePoint lower;
  delaunay::LatticePoint upper;
};

/// How a model goes from a triangle to what is behind an edge.
struct Neighbours {
  /// in_mesh: by the twins of its mesh; in_model: by walk().
  enum class Place : std::uint8_t { nowhere, in_mesh, in_model };
  Place place = Place::nowhere;
  std::string how;  ///< In words; where there are none why not.
};

/// How many levels a model has.
struct ModelLevels {
  int n = 0;
  std::string what;  ///< They are; where there are none why not.
};

/// What some models have no answer to.
enum class ModelPart : std::uint8_t { memory, file, links, variable, zoom, location };

/// A model of terrain as compare_terrain() runs it.
class TerrainCandidate {
 public:
  struct Answer {
    delaunay::Tin tin;       ///< With heights.
    std::int32_t scale = 1;  ///< Of its lattice: nodes from one column or row to the next.
    std::optional<double> stated_error{};
  };

  virtual ~TerrainCandidate() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual std::string what() const = 0;
  /// What is done once for all tolerances, which the others are among. Fails where the model cannot
  /// take the grid. The grid must outlive the model.
  [[nodiscard]] virtual Result<void> prepare(const HeightGrid& grid,
                                             std::span<const double> tolerances, Threads threads,
                                             Progress& progress) = 0;
  /// The same of scattered points. Of models that need columns and rows it fails, and says so.
  [[nodiscard]] virtual Result<void> prepare_points(const PointTerrain& terrain,
                                                    std::span<const double> tolerances,
                                                    Threads threads, Progress& progress);
  [[nodiscard]] virtual Result<Answer> extract(double tolerance, Progress& progress) = 0;
  /// Within the tolerance in the middle quarter of columns and of rows, a sixteenth of the area,
  /// within ten times outside:
  /// the number of triangles. Of those that can_vary().
  [[nodiscard]] virtual Result<std::uint64_t> extract_middle(double tolerance, Progress& progress);
  [[nodiscard]] virtual bool can_vary() const { return false; }
  /// Of what prepare() does.
  [[nodiscard]] virtual std::optional<double> build_seconds() const { return {}; }
  /// Whether extract() starts from the raster again, so that all meshes are what is built.
  [[nodiscard]] virtual bool is_made_anew() const { return false; }
  /// Those that it has whatever is asked of it, or, where it is built at tolerances, these.
  [[nodiscard]] virtual ModelLevels levels() const = 0;
  /// Of the whole model, where it is in memory.
  [[nodiscard]] virtual std::optional<std::uint64_t> memory_bytes() const { return {}; }
  [[nodiscard]] virtual std::optional<std::uint64_t> n_links() const { return {}; }
  /// How many triangles within the tolerance meet a window, found without all of the mesh; nothing
  /// where the model cannot.
  [[nodiscard]] virtual Result<std::optional<std::uint64_t>> zoom(double tolerance,
                                                                  const TerrainWindow& window);
  /// In how many of the places it finds a triangle within the tolerance, without a mesh; nothing
  /// where the model cannot.
  [[nodiscard]] virtual std::optional<std::uint64_t> locate(
      double tolerance, std::span<const delaunay::LatticePoint> places);
  /// Of models whose meshes have gaps: the surface within the tolerance, to go along; else null. It
  /// may use the model.
  [[nodiscard]] virtual Result<std::shared_ptr<const TerrainPatches>> patches(double tolerance,
                                                                              Progress& progress);
  [[nodiscard]] virtual Neighbours neighbours() const = 0;
  /// Why it has no such part, of those that it lacks; unless it says otherwise, as it is made anew.
  [[nodiscard]] virtual std::string why_not(ModelPart part) const;
  /// walk_edges() in the mesh within the tolerance, without one, from one of its triangles. Of
  /// those whose neighbours are in_model; extract() was called with the tolerance before.
  [[nodiscard]] virtual std::uint64_t walk(double tolerance, std::uint64_t n_tries,
                                           std::uint64_t seed);
};

/// Of models whose meshes do not come with twins.
[[nodiscard]] Neighbours sorted_twins();

/// What extract_middle() asks, in the world.
[[nodiscard]] FocusDemand middle_demand(const HeightFrame& frame, double tolerance);

/// All there are, the baseline last. `memory_limit`: of interference links, whose number may be
/// quadratic; a model that takes more fails to be prepared.
[[nodiscard]] std::vector<std::unique_ptr<TerrainCandidate>> terrain_candidates(
    std::uint64_t memory_limit);

}  // namespace lode
