#include "lode/models/terrain/terrain_features/merge_sweep.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

namespace lode::terrain_features {
namespace {

constexpr std::size_t kPassesAtOnce = 4096;

}  // namespace

MergeSweep::MergeSweep(const VertexLinks& links, SweepFrom from, std::vector<std::uint32_t> next)
    : links_(links), from_(from), next_(std::move(next)) {
  if (from_ == SweepFrom::below) extrema_.push_back(links_.outside());
  for (std::uint32_t v = 0; v < links_.n_vertices(); ++v)
    if (next_[v] == v) extrema_.push_back(v);
  reliefs_.assign(extrema_.size(), std::numeric_limits<double>::infinity());
  elders_.resize(extrema_.size());
  std::iota(elders_.begin(), elders_.end(), 0U);
}

void MergeSweep::find_basins() {
  basins_.assign(links_.n_vertices(), kNone);
  for (std::uint32_t e = 0; e < extrema_.size(); ++e)
    if (extrema_[e] != links_.outside()) basins_[extrema_[e]] = e;
  for (std::uint32_t v = 0; v < links_.n_vertices(); ++v) {
    if (next_[v] == kNone) continue;
    std::uint32_t end = v;
    while (end != links_.outside() && basins_[end] == kNone) end = next_[end];
    const std::uint32_t basin = basin_of(end);
    for (std::uint32_t at = v; at != end; at = next_[at]) basins_[at] = basin;
  }
}

std::uint32_t MergeSweep::component_of(std::uint32_t extremum) {
  while (elders_[extremum] != extremum) extremum = elders_[extremum] = elders_[elders_[extremum]];
  return extremum;
}

double MergeSweep::relief_at(const Pass& pass, std::uint32_t extremum) const {
  const double rise = links_.height(pass.vertex) - links_.height(extrema_[extremum]);
  return from_ == SweepFrom::below ? rise : -rise;
}

void MergeSweep::join_arcs(Pass& pass, std::span<const std::uint32_t> arcs) {
  std::uint32_t eldest_arc = arcs[0];
  std::uint32_t eldest = component_of(basin_of(eldest_arc));
  for (const std::uint32_t arc : arcs.subspan(1)) {
    const std::uint32_t component = component_of(basin_of(arc));
    if (!is_older(component, eldest)) continue;
    eldest = component;
    eldest_arc = arc;
  }
  // The pass itself is in one of the arcs' basins. Others that are joined by pairs not kept are led
  // through it, and that one, should it be among them, to the eldest.
  const std::uint32_t own_basin = basin_of(pass.vertex);
  const std::uint32_t own = component_of(own_basin);
  for (const std::uint32_t arc : arcs) {
    const std::uint32_t basin = basin_of(arc);
    const std::uint32_t component = component_of(basin);
    if (component == eldest) continue;
    const double relief = relief_at(pass, component);
    elders_[component] = eldest;
    ++pass.n_pairs;
    pass.relief = std::max(pass.relief, relief);
    reliefs_[component] = relief;
    if (relief >= least_relief_) {
      ++pass.n_kept;
    } else if (component == own) {
      joints_.push_back({pass.vertex, eldest_arc, own_basin, basin_of(eldest_arc)});
    } else {
      joints_.push_back({pass.vertex, arc, own_basin, basin});
    }
  }
}

void MergeSweep::pair_extrema(std::span<Pass> passes, double least_relief, Progress& progress) {
  least_relief_ = least_relief;
  find_basins();
  Arcs arcs(links_);
  for (std::size_t i = 0; i < passes.size(); ++i) {
    if (i % kPassesAtOnce == 0) {
      if (progress.is_cancelled()) return;
      progress.report(from_ == SweepFrom::below ? "pairs of pits" : "pairs of peaks",
                      static_cast<double>(i) / static_cast<double>(passes.size()));
    }
    Pass& pass = from_ == SweepFrom::below ? passes[i] : passes[passes.size() - 1 - i];
    arcs.look_round(pass.vertex);
    join_arcs(pass, from_ == SweepFrom::below ? arcs.lower() : arcs.upper());
  }
  basins_ = {};
}

void MergeSweep::list_joints() {
  joint_first_.assign(extrema_.size() + 1, 0);
  for (const Joint& joint : joints_)
    for (const std::uint32_t e : {joint.pass_basin, joint.arc_basin}) ++joint_first_[e];
  std::partial_sum(joint_first_.begin(), joint_first_.end(), joint_first_.begin());
  joint_lists_.resize(2 * joints_.size());
  for (std::uint32_t i = 0; i < joints_.size(); ++i)
    for (const std::uint32_t e : {joints_[i].pass_basin, joints_[i].arc_basin})
      joint_lists_[--joint_first_[e]] = i;
}

/// The way from a vertex to its extremum now leads from there to the vertex, and on to the exit.
void MergeSweep::turn_round(std::uint32_t from, std::uint32_t exit) {
  std::uint32_t last = exit;
  for (std::uint32_t at = from; true;) {
    const std::uint32_t following = std::exchange(next_[at], last);
    if (following == at) return;
    last = at;
    at = following;
  }
}

void MergeSweep::reroute() {
  // Joints are the edges of a forest over the extrema, and each tree of it has exactly one that is
  // kept (docs/models/terrain_features.md). From there on each basin gets its exit.
  list_joints();
  std::vector<std::uint32_t> reached;
  std::vector<bool> is_reached(extrema_.size());
  for (std::uint32_t e = 0; e < extrema_.size(); ++e)
    if (is_kept(e)) {
      reached.push_back(e);
      is_reached[e] = true;
    }
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (std::uint32_t j = joint_first_[reached[i]]; j < joint_first_[reached[i] + 1]; ++j) {
      const Joint& joint = joints_[joint_lists_[j]];
      const bool is_from_arc = joint.arc_basin == reached[i];
      const std::uint32_t other = is_from_arc ? joint.pass_basin : joint.arc_basin;
      if (is_reached[other]) continue;
      is_reached[other] = true;
      reached.push_back(other);
      if (is_from_arc) {
        turn_round(joint.pass, joint.arc);
      } else {
        turn_round(joint.arc, joint.pass);
      }
    }
  joints_ = {};
  joint_first_ = {};
  joint_lists_ = {};
}

}  // namespace lode::terrain_features
