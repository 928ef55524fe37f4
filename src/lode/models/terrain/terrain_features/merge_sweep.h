#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/terrain/terrain_features/vertex_links.h"

namespace lode::terrain_features {

/// A pass, and what both sweeps find out about it.
struct Pass {
  std::uint32_t vertex;
  std::uint32_t multiplicity;
  std::uint32_t n_pairs = 0;
  std::uint32_t n_kept = 0;  ///< Of its pairs.
  double relief = 0;         ///< The largest of its pairs'.
};

/// Whether vertices join from the lowest on, and their components begin at pits and outside, or
/// from the highest on, and they begin at peaks.
enum class SweepFrom : std::uint8_t { below, above };

/// Joins the components of what is lower (or higher) than a vertex that rises (or falls), and pairs
/// the pass where two meet with the one of their oldest extrema that is younger (H. Edelsbrunner,
/// D. Letscher, A. Zomorodian, "Topological persistence and simplification", 2002).
class MergeSweep {
 public:
  /// `next`: per vertex the neighbour that the sweep comes from, itself for an extremum, what
  /// is outside where there is no other; kNone for those of no triangle. The links outlive it.
  MergeSweep(const VertexLinks& links, SweepFrom from, std::vector<std::uint32_t> next);

  /// `passes` rise. Pairs with less than `least_relief` are not kept. Stops when cancelled.
  void pair_extrema(std::span<Pass> passes, double least_relief, Progress& progress);
  /// Afterwards next() leads everything to extrema that are kept, or outside.
  void reroute();

  /// Nodes: from below first what is outside, then vertices.
  [[nodiscard]] const std::vector<std::uint32_t>& extrema() const { return extrema_; }
  /// Of extrema, by number; infinite without a pair.
  [[nodiscard]] double relief(std::size_t extremum) const { return reliefs_[extremum]; }
  [[nodiscard]] bool is_kept(std::size_t extremum) const {
    return reliefs_[extremum] >= least_relief_;
  }
  [[nodiscard]] const std::vector<std::uint32_t>& next() const { return next_; }

 private:
  /// A pair not kept joins the basin that the pass is in with that of an arc, an extremum each.
  struct Joint {
    std::uint32_t pass;  ///< A vertex.
    std::uint32_t arc;   ///< The first node of the arc.
    std::uint32_t pass_basin;
    std::uint32_t arc_basin;
  };

  [[nodiscard]] bool is_older(std::uint32_t a, std::uint32_t b) const {
    return from_ == SweepFrom::below ? links_.is_below(extrema_[a], extrema_[b])
                                     : links_.is_below(extrema_[b], extrema_[a]);
  }
  void find_basins();
  [[nodiscard]] std::uint32_t basin_of(std::uint32_t node) const {
    return node == links_.outside() ? 0 : basins_[node];
  }
  [[nodiscard]] std::uint32_t component_of(std::uint32_t extremum);
  [[nodiscard]] double relief_at(const Pass& pass, std::uint32_t extremum) const;
  void join_arcs(Pass& pass, std::span<const std::uint32_t> arcs);
  void list_joints();
  void turn_round(std::uint32_t from, std::uint32_t exit);

  const VertexLinks& links_;
  SweepFrom from_;
  double least_relief_ = 0;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> extrema_;
  std::vector<double> reliefs_;
  std::vector<std::uint32_t>
      elders_;  ///< Per extremum one that its component has joined, or itself.
  std::vector<std::uint32_t> basins_;  ///< Per vertex the extremum that next_ leads to.
  std::vector<Joint> joints_;
  std::vector<std::uint32_t> joint_first_;  ///< Per extremum, and one more: in joint_lists_.
  std::vector<std::uint32_t> joint_lists_;
};

}  // namespace lode::terrain_features
