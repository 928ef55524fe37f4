#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/distance_cut.h"

namespace lode {

/// What surfaces of one cut have in common.
struct CommonNodes {
  std::optional<diamond::NodeSet<3>> wanted;  ///< To be refined; nothing where none are looked for.
  diamond::WeakSamples weak;

  /// Whether the field's first sample is among those of an isovalue.
  [[nodiscard]] bool is_first_weak(double isovalue) const {
    const auto found = weak.find(isovalue);
    return found != weak.end() && found->second.contains({});
  }
};

/// Finds what an isovalue wants refined, from a model in memory or from a file.
struct NodeSearch {
  using Nodes = diamond::NodeSet<3>;
  std::function<Nodes()> none;  ///< Of the lattice.
  /// What nodes may take of memory.
  std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max();
  /// Beside those that are given, in so many bytes of a file's.
  std::function<Result<diamond::CriticalNodes>(double isovalue, const Nodes& nodes,
                                               std::uint64_t max_bytes)>
      critical;
  /// With all that are given.
  std::function<Result<diamond::DistanceCut>(double isovalue, Nodes nodes)> within_distance;
};

/// Whether there is anything to be found.
[[nodiscard]] bool has_common_nodes(const ExtractOptions& options, const ExtractReport& report);

/// The nodes that keep_topology and max_distance want refined whatever their error, of all
/// isovalues together: so all their surfaces lie in one cut, where none meets another. Each is held
/// to its distance in that cut, again where others have added to it; so is its topology with a
/// persistence, of which it depends on all nodes what may go. Adds what it finds, and the time, to
/// the report.
[[nodiscard]] Result<CommonNodes> find_common_nodes(const ExtractOptions& options,
                                                    const NodeSearch& search, ExtractReport& report,
                                                    Progress& progress);

}  // namespace lode
