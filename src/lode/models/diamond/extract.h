#pragma once

#include <array>
#include <limits>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/surface.h"
#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/cube_meter.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/weak_regions.h"

namespace lode::diamond {

struct IsosurfaceQuery {
  double isovalue = 0;
  double tolerance = 0;  ///< Field units; 0 refines every active node, infinity none for its error.
  /// Also refined, of a volume; may be null. Must outlive the query.
  const NodeSet<3>* wanted = nullptr;
  /// Of a volume, whose pieces are left out; may be null. Must outlive the query.
  const WeakSamples* weak = nullptr;
  /// cubes, of a volume: full resolution, where tetrahedra stay wherever |F - isovalue| would not
  /// keep within the tolerance; at tolerance 0 there is no bound (see CubeCells).
  SurfaceStyle style = SurfaceStyle::tetra;
  /// Tetrahedra stay, too, where cubes are not within this of them and back, world units.
  double style_distance = std::numeric_limits<double>::infinity();
  bool with_deviation = false;  ///< Of cubes, whether their deviation is measured.
  Threads threads{};
  bool with_normals = false;  ///< Normals too; see normals.h.
  /// Full resolution gives its vertices their isovalue too, while they are at hand.
  bool with_isovalues = false;
  bool replaces = false;  ///< The surface is overwritten, its memory used as it is.

  /// Null where nothing of an isovalue's surface is left out.
  [[nodiscard]] const NodeSet<3>* weak_of(double value) const {
    if (weak == nullptr) return nullptr;
    const auto found = weak->find(value);
    return found == weak->end() ? nullptr : &found->second;
  }
  /// Of nodes' errors: cubes are of full resolution.
  [[nodiscard]] double cut_tolerance() const {
    return style == SurfaceStyle::cubes ? 0 : tolerance;
  }
  /// Of cubes.
  [[nodiscard]] CubeLimit style_limit() const {
    return {.error = tolerance > 0 ? tolerance : std::numeric_limits<double>::infinity(),
            .distance = style_distance};
  }
};

struct IsosurfaceReport {
  double achieved_error = 0;    ///< Largest nested error of an active node left unrefined.
  bool has_isovalues = false;   ///< The surface's vertices have theirs.
  CubeDeviation deviation;      ///< Where asked for.
  double coordinate_slack = 0;  ///< What margins and rounding may add to |F - isovalue|.
  std::uint64_t nodes_visited = 0;
  double select_seconds = 0;    ///< Traversal and marching, which run together.
  double geometry_seconds = 0;  ///< Stitching and positions.
  double measure_seconds = 0;   ///< The deviation.
  /// Of a file, in bytes: the largest of the surfaces, and the most that one's parts of a chunk
  /// take.
  std::uint64_t surface_bytes = 0;
  std::uint64_t part_bytes = 0;
};

/// A leaf simplex of the cut that the isosurface crosses, in lattice coordinates.
template <int D>
struct ActiveSimplex {
  std::array<Index<D>, as_size(D) + 1> vertex;
  std::array<double, as_size(D) + 1> value;
};

/// Extracts one isosurface (contour lines in 2D) straight from the hierarchy: bricks in parallel,
/// then stitched. Simplices that reach across the domain's border are refined, so that it ends
/// exactly there. Appends positions, cells and, where asked for, normals to `surface`, or replaces
/// it.
template <int D>
[[nodiscard]] Result<IsosurfaceReport> extract_isosurface(const Model<D>& model,
                                                          const IsosurfaceQuery& query,
                                                          Surface& surface, Progress& progress);

/// The leaf simplices the same query's surface comes from, brick by brick in a fixed order.
template <int D>
[[nodiscard]] std::vector<ActiveSimplex<D>> active_simplices(const Model<D>& model,
                                                             const IsosurfaceQuery& query);

}  // namespace lode::diamond
