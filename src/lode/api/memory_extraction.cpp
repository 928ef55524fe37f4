#include "lode/api/memory_extraction.h"

#include <utility>

#include "lode/api/common_nodes.h"
#include "lode/api/topology_extraction.h"

namespace lode {
namespace {

/// Of a volume.
Result<CommonNodes> common_nodes(const Dataset::Impl& impl, const diamond::Model<3>& model,
                                 const ExtractOptions& options, ExtractReport& report,
                                 Progress& progress) {
  const NodeSearch search{
      .none = [&] { return diamond::NodeSet<3>(model.shape); },
      .critical =
          [&](double isovalue, const diamond::NodeSet<3>& nodes, std::uint64_t /*max_bytes*/) {
            return diamond::find_critical_nodes(
                model,
                {.isovalue = isovalue,
                 .persistence = *options.keep_topology,
                 .threads = options.threads,
                 .tolerance = query_of<3>(isovalue, options, report).cut_tolerance(),
                 .refined = &nodes,
                 .with_weak = report.topology->leaves_out_weak},
                progress);
          },
      .within_distance = [&](double isovalue,
                             const diamond::NodeSet<3>& nodes) -> Result<diamond::DistanceCut> {
        diamond::IsosurfaceQuery query = query_of<3>(isovalue, options, report);
        query.wanted = &nodes;
        LODE_TRY(const auto worlds, impl.world_errors(progress));
        return diamond::find_distance_cut(model, query, *options.max_distance, *worlds, progress);
      }};
  return find_common_nodes(options, search, report, progress);
}

}  // namespace

Result<FieldFacts> extract_in_memory(const Dataset::Impl& impl, const ExtractOptions& options,
                                     Surface& surface, ExtractReport& report, Progress& progress) {
  LODE_TRY(const auto* const held, impl.model(progress));
  begin_topology(options, report);
  if (options.max_distance) report.distance = DistanceReport{.max_distance = *options.max_distance};
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> Result<FieldFacts> {
        CommonNodes common;
        if constexpr (D == 3) {
          LODE_TRY(common, common_nodes(impl, model, options, report, progress));
        }
        for (const double isovalue : options.isovalues) {
          auto query = query_of<D>(isovalue, options, report);
          query.wanted = common.wanted ? &*common.wanted : nullptr;
          query.weak = &common.weak;
          LODE_TRY(const auto part,
                   diamond::extract_isosurface<D>(model, query, surface, progress));
          add_part(part, report);
          if (!part.has_isovalues) add_isovalue(isovalue, options, surface);
        }
        // At full resolution it is the surface that it is to be near.
        if (report.distance && report.max_error == 0)
          report.distance->full_triangles = surface.triangles.size();
        const bool closes = options.border == Border::closed;
        return FieldFacts{model.info.grid,
                          closes && model.has_holes() && model.has_removed_border_cell(),
                          model.value({}), common.is_first_weak(options.isovalues.front())};
      },
      *held);
}

}  // namespace lode
