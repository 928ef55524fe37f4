#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/mappers/facet_grid.h"
#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// How a distance was kept.
struct DistanceCutReport {
  double proven = 0;                   ///< World units: no point of either surface is farther.
  std::uint64_t n_rounds = 0;          ///< How often the surface was held against the true one.
  std::uint64_t n_nodes = 0;           ///< Refined for the distance.
  std::uint64_t n_full_triangles = 0;  ///< Of the true surface.
  std::uint64_t n_lost = 0;            ///< Its triangles that no refinement brought near,
  double lost_size = 0;                ///< and the diagonal of the box round them, world units.
};

/// World errors of more than this many distances asked for are not tried. A larger number leaves
/// fewer triangles (bonsai at 1 voxel: 665,000 with 4, 612,000 with 8) and takes longer (2.5
/// times).
inline constexpr double kFarOffDistances = 4;

/// A field, or a part of it, in which a cut's surface is held against that of full resolution, and
/// the nodes that are wanted refined.
class DistanceWindow {
 public:
  /// The window's own facets, and behind them others round it.
  struct Facets {
    std::vector<Facet> all;
    std::size_t n_own = 0;
  };

  virtual ~DistanceWindow() = default;

  /// Of full resolution; places as of full_facets().
  [[nodiscard]] virtual Facets full(const Progress& progress) = 0;
  /// Of the cut; places as of cut_facets(). Those of leaves that forget_new() has not heard of yet
  /// are marked fresh; the first time all.
  [[nodiscard]] virtual Facets cut(const Progress& progress) = 0;
  /// Wants, before anything is held, what will have to be refined by all signs: how many nodes that
  /// are new.
  virtual std::uint64_t insert_guess() = 0;
  /// Wants a node, and all that must be refined before: how many that are new.
  virtual std::uint64_t insert(const Index<3>& centre) = 0;
  virtual void forget_new() = 0;
  [[nodiscard]] virtual bool contains(const Index<3>& centre) const = 0;
  /// Whether the cut bisects a simplex round an own facet of full resolution.
  [[nodiscard]] virtual bool is_refined(const Simplex<3>& simplex) const = 0;
  /// Of the whole field.
  [[nodiscard]] virtual const Shape<3>& shape() const = 0;
  /// Of all that is to be held, for progress.
  [[nodiscard]] virtual double share_done() const { return 0; }
};

/// Finds which nodes to refine so that no point of a window's own facets of either surface is
/// farther than `max_distance` from the other surface. docs/models/diamond3d.md has the proof.
/// Deterministic; fails when cancelled.
[[nodiscard]] Result<DistanceCutReport> search_distance(DistanceWindow& window, double max_distance,
                                                        Threads threads, Progress& progress);

}  // namespace lode::diamond
