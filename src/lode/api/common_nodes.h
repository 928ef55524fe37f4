#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/distance_cut.h"

namespace lode {

/// Finds what an isovalue wants refined, from a model in memory or from a file.
struct NodeSearch {
  using Nodes = diamond::NodeSet<3>;
  std::function<Nodes()> none;  ///< Of the lattice.
  /// What nodes may take of memory.
  std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max();
  /// Beside those that are given.
  std::function<Result<diamond::CriticalNodes>(double isovalue, const Nodes& nodes)> critical;
  /// With all that are given.
  std::function<Result<diamond::DistanceCut>(double isovalue, Nodes nodes)> within_distance;
};

/// The nodes that keep_topology and max_distance want refined whatever their error, of all
/// isovalues together: so all their surfaces lie in one cut, where none meets another. Each is held
/// to its distance in that cut, again where others have added to it; so is its topology with a
/// persistence, of which it depends on all nodes what may go. Nothing where none are wanted.
/// Adds what it finds, and the time, to the report.
[[nodiscard]] Result<std::optional<diamond::NodeSet<3>>> find_common_nodes(
    const ExtractOptions& options, const NodeSearch& search, ExtractReport& report,
    Progress& progress);

}  // namespace lode
