#include "lode/api/common_nodes.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
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

std::uint64_t bytes_of(const diamond::WeakSamples& weak) {
  std::uint64_t n_bytes = 0;
  for (const auto& [isovalue, samples] : weak) n_bytes += samples.n_bytes();
  return n_bytes;
}

Result<void> check_size(const NodeSearch& search, const CommonNodes& nodes) {
  const std::uint64_t n_bytes = nodes.wanted->n_bytes() + bytes_of(nodes.weak);
  if (n_bytes <= search.max_bytes) return {};
  return fail(
      "keeping the topology: expected at most {} MB for the nodes that all isovalues take, got {} "
      "MB: a higher memory limit, or fewer isovalues, leaves room for them",
      search.max_bytes / 1'000'000, n_bytes / 1'000'000 + 1);
}

/// With a persistence until each isovalue was looked at with all the nodes that there are.
Result<void> add_critical_nodes(const ExtractOptions& options, const NodeSearch& search,
                                CommonNodes& nodes, ExtractReport& report, Progress& progress) {
  const Stopwatch watch;
  const std::vector<double> isovalues = sorted_isovalues(options.isovalues);
  const std::size_t n = isovalues.size();
  std::vector<std::uint64_t> n_weak(n);
  std::size_t n_held = 0;  // The last so many, with these nodes.
  for (std::size_t i = 0; n_held < n; i = (i + 1) % n) {
    progress.report("finding critical nodes", 0);
    nodes.weak.erase(isovalues[i]);
    LODE_TRY(diamond::CriticalNodes found,
             search.critical(isovalues[i], *nodes.wanted,
                             search.max_bytes - std::min(search.max_bytes, bytes_of(nodes.weak))));
    const std::uint64_t n_new = nodes.wanted->join(found.nodes);
    n_weak[i] = found.weak.n;
    if (found.weak.samples) nodes.weak.emplace(isovalues[i], std::move(*found.weak.samples));
    LODE_CHECK(check_size(search, nodes));
    n_held = *options.keep_topology > 0 && n_new > 0 ? 1 : n_held + 1;
    report.topology->critical_nodes += found.n_critical;
    report.topology->nodes += n_new;
  }
  report.topology->weak_regions = std::accumulate(n_weak.begin(), n_weak.end(), std::uint64_t{0});
  report.seconds.topology += watch.seconds();
  return {};
}

/// Until each isovalue was held to the distance with all the nodes that there are. How many there
/// are more.
Result<std::uint64_t> add_near_nodes(const ExtractOptions& options, const NodeSearch& search,
                                     NodeSearch::Nodes& nodes,
                                     std::vector<diamond::DistanceCutReport>& found,
                                     ExtractReport& report) {
  const Stopwatch watch;
  const std::vector<double> isovalues = sorted_isovalues(options.isovalues);
  const std::size_t n = isovalues.size();
  std::uint64_t n_added = 0;
  std::size_t n_held = 0;  // The last so many, with these nodes.
  for (std::size_t i = 0; n_held < n; i = (i + 1) % n) {
    LODE_TRY(diamond::DistanceCut cut, search.within_distance(isovalues[i], std::move(nodes)));
    nodes = std::move(cut.nodes);
    n_held = cut.report.n_nodes > 0 ? 1 : n_held + 1;
    n_added += cut.report.n_nodes;
    cut.report.n_rounds += found[i].n_rounds;
    cut.report.n_nodes += found[i].n_nodes;
    cut.report.n_lost += found[i].n_lost;
    cut.report.lost_size = std::max(cut.report.lost_size, found[i].lost_size);
    found[i] = cut.report;
  }
  report.seconds.distance += watch.seconds();
  return n_added;
}

bool has_critical(const ExtractReport& report) {
  return report.topology && (report.topology->is_searched || report.topology->leaves_out_weak);
}

bool has_near(const ExtractOptions& options, const ExtractReport& report) {
  return options.max_distance && report.max_error > 0;
}

}  // namespace

bool has_common_nodes(const ExtractOptions& options, const ExtractReport& report) {
  return has_critical(report) || has_near(options, report);
}

Result<CommonNodes> find_common_nodes(const ExtractOptions& options, const NodeSearch& search,
                                      ExtractReport& report, Progress& progress) {
  CommonNodes nodes;
  if (!has_common_nodes(options, report)) return nodes;
  const bool is_near = has_near(options, report);
  nodes.wanted = search.none();
  std::vector<diamond::DistanceCutReport> near(options.isovalues.size());
  for (std::uint64_t n_added = 1; n_added > 0;) {
    n_added = 0;
    if (has_critical(report))
      LODE_CHECK(add_critical_nodes(options, search, nodes, report, progress));
    if (is_near) {
      LODE_TRY(n_added, add_near_nodes(options, search, *nodes.wanted, near, report));
    }
    // What the distance adds may undo what a persistence has found.
    if (!has_critical(report) || *options.keep_topology == 0) break;
  }
  if (is_near)
    for (const diamond::DistanceCutReport& one : near) add_distance(one, report);
  const bool refines = is_near || (report.topology && report.topology->is_searched);
  if (!refines) nodes.wanted.reset();
  return nodes;
}

}  // namespace lode
