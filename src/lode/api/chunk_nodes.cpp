#include "lode/api/chunk_nodes.h"

#include <utility>

#include "lode/api/topology_extraction.h"

namespace lode {

WantedNodes ChunkNodes::begin(ExtractReport& report, Progress& progress) {
  begin_topology(options_, report);
  if (options_.max_distance)
    report.distance =
        DistanceReport{.max_distance = *options_.max_distance, .memory_limit = memory_limit_};
  if (!has_common_nodes(options_, report)) return {};
  return [this, &report, &progress]() -> Result<const CommonNodes*> {
    if (!nodes_) LODE_CHECK(find(report, progress));
    return &*nodes_;
  };
}

Result<void> ChunkNodes::find(ExtractReport& report, Progress& progress) {
  const auto& field = std::get<diamond::CoarseField<3>>(chunks_.field);
  const std::uint64_t node_bytes = memory_limit_ / 4;
  const NodeSearch search{
      .none = [&] { return diamond::NodeSet<3>(field.shape); },
      .max_bytes = node_bytes,
      .critical =
          [&](double isovalue, const diamond::NodeSet<3>& nodes, std::uint64_t max_bytes) {
            return diamond::find_critical_nodes(
                field, chunks_.blocks,
                {.isovalue = isovalue,
                 .persistence = *options_.keep_topology,
                 .threads = options_.threads,
                 .max_bytes = max_bytes,
                 .tolerance = query_of<3>(isovalue, options_, report).cut_tolerance(),
                 .refined = &nodes,
                 .with_weak = report.topology->leaves_out_weak},
                progress);
          },
      .within_distance =
          [&](double isovalue, diamond::NodeSet<3> nodes) {
            diamond::FileDistanceQuery within{.surface = query_of<3>(isovalue, options_, report),
                                              .wanted = std::move(nodes),
                                              .max_distance = *options_.max_distance,
                                              .node_bytes = node_bytes,
                                              .window_bytes = memory_limit_ / 2};
            return diamond::find_distance_cut(field, chunks_.blocks, std::move(within), progress);
          }};
  LODE_TRY(nodes_, find_common_nodes(options_, search, report, progress));
  return {};
}

}  // namespace lode
