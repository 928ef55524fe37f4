#include "lode/api/chunk_nodes.h"

#include "lode/api/distance_extraction.h"
#include "lode/api/topology_extraction.h"
#include "lode/core/stopwatch.h"

namespace lode {

NodesOfIsovalue ChunkNodes::begin(ExtractReport& report, Progress& progress) {
  begin_topology(options_, report);
  if (options_.max_distance)
    report.distance =
        DistanceReport{.max_distance = *options_.max_distance, .memory_limit = memory_limit_};
  const bool is_searched = (report.topology && report.topology->is_searched) ||
                           (options_.max_distance && report.max_error > 0);
  if (!is_searched) return {};
  return [this, &report, &progress](double isovalue) { return find(isovalue, report, progress); };
}

Result<const diamond::NodeSet<3>*> ChunkNodes::find(double isovalue, ExtractReport& report,
                                                    Progress& progress) {
  const auto& field = std::get<diamond::CoarseField<3>>(chunks_.field);
  critical_.reset();
  near_.reset();
  diamond::IsosurfaceQuery query = query_of<3>(isovalue, options_, report);
  const std::uint64_t node_bytes = memory_limit_ / 4;
  if (report.topology && report.topology->is_searched) {
    const Stopwatch watch;
    progress.report("finding critical nodes", 0);
    LODE_TRY(critical_,
             diamond::find_critical_nodes(
                 field, chunks_.blocks,
                 {isovalue, *options_.keep_topology, options_.threads, node_bytes}, progress));
    add_critical(*critical_, watch.seconds(), report);
    query.wanted = &critical_->nodes;
  }
  if (options_.max_distance) {
    const Stopwatch watch;
    diamond::FileDistanceQuery within{
        .surface = query_of<3>(isovalue, options_, report),
        .wanted = critical_ ? std::move(critical_->nodes) : diamond::NodeSet<3>(field.shape),
        .max_distance = *options_.max_distance,
        .node_bytes = node_bytes,
        .window_bytes = memory_limit_ / 2};
    critical_.reset();
    LODE_TRY(near_, diamond::find_distance_cut(field, chunks_.blocks, std::move(within), progress));
    add_distance(near_->report, watch.seconds(), report);
    query.wanted = &near_->nodes;
  }
  return query.wanted;
}

}  // namespace lode
