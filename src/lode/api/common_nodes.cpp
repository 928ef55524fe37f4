#include "lode/api/common_nodes.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "lode/api/distance_extraction.h"
#include "lode/api/topology_extraction.h"
#include "lode/core/stopwatch.h"

namespace lode {
namespace {

/// So that the nodes are the same however they are named.
std::vector<double> sorted_isovalues(std::vector<double> isovalues) {
  std::ranges::sort(isovalues);
  return isovalues;
}

Result<void> add_critical_nodes(const ExtractOptions& options, const NodeSearch& search,
                                NodeSearch::Nodes& nodes, ExtractReport& report,
                                Progress& progress) {
  for (const double isovalue : sorted_isovalues(options.isovalues)) {
    const Stopwatch watch;
    progress.report("finding critical nodes", 0);
    LODE_TRY(const diamond::CriticalNodes found, search.critical(isovalue));
    nodes.join(found.nodes);
    if (nodes.n_bytes() > search.max_bytes)
      return fail(
          "keeping the topology: expected at most {} MB for the nodes that all isovalues take, got "
          "{} MB: a higher memory limit, or fewer isovalues, leaves room for them",
          search.max_bytes / 1'000'000, nodes.n_bytes() / 1'000'000 + 1);
    add_critical(found, watch.seconds(), report);
  }
  return {};
}

/// Until each isovalue was held to the distance with all the nodes that there are.
Result<void> add_near_nodes(const ExtractOptions& options, const NodeSearch& search,
                            NodeSearch::Nodes& nodes, ExtractReport& report) {
  const Stopwatch watch;
  const std::vector<double> isovalues = sorted_isovalues(options.isovalues);
  const std::size_t n = isovalues.size();
  std::vector<diamond::DistanceCutReport> found(n);
  std::size_t n_held = 0;  // The last so many, with these nodes.
  for (std::size_t i = 0; n_held < n; i = (i + 1) % n) {
    LODE_TRY(diamond::DistanceCut cut, search.within_distance(isovalues[i], std::move(nodes)));
    nodes = std::move(cut.nodes);
    n_held = cut.report.n_nodes > 0 ? 1 : n_held + 1;
    cut.report.n_rounds += found[i].n_rounds;
    cut.report.n_nodes += found[i].n_nodes;
    cut.report.n_lost += found[i].n_lost;
    cut.report.lost_size = std::max(cut.report.lost_size, found[i].lost_size);
    found[i] = cut.report;
  }
  for (const diamond::DistanceCutReport& one : found) add_distance(one, report);
  report.seconds.distance += watch.seconds();
  return {};
}

}  // namespace

Result<std::optional<NodeSearch::Nodes>> find_common_nodes(const ExtractOptions& options,
                                                           const NodeSearch& search,
                                                           ExtractReport& report,
                                                           Progress& progress) {
  const bool has_critical = report.topology && report.topology->is_searched;
  const bool has_near = options.max_distance && report.max_error > 0;
  if (!has_critical && !has_near) return std::optional<NodeSearch::Nodes>();
  NodeSearch::Nodes nodes = search.none();
  if (has_critical) LODE_CHECK(add_critical_nodes(options, search, nodes, report, progress));
  if (has_near) LODE_CHECK(add_near_nodes(options, search, nodes, report));
  return std::optional(std::move(nodes));
}

}  // namespace lode
