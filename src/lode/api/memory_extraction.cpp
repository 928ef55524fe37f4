#include "lode/api/memory_extraction.h"

#include <optional>

#include "lode/api/distance_extraction.h"
#include "lode/api/topology_extraction.h"

namespace lode {
namespace {

template <int D>
Result<diamond::IsosurfaceReport> extract_one(const Dataset::Impl& impl,
                                              const diamond::Model<D>& model,
                                              diamond::IsosurfaceQuery query,
                                              const ExtractOptions& options, Surface& surface,
                                              ExtractReport& report, Progress& progress) {
  std::optional<diamond::CriticalNodes> critical;
  if constexpr (D == 3)
    if (report.topology && report.topology->is_searched) {
      LODE_TRY(critical, critical_nodes(model, query.isovalue, options, report, progress));
      query.wanted = &critical->nodes;
    }
  if (options.max_distance)
    return extract_within_distance(impl, query, options, surface, report, progress);
  return diamond::extract_isosurface<D>(model, query, surface, progress);
}

}  // namespace

Result<FieldFacts> extract_in_memory(const Dataset::Impl& impl, const ExtractOptions& options,
                                     Surface& surface, ExtractReport& report, Progress& progress) {
  LODE_TRY(const auto* const held, impl.model(progress));
  begin_topology(options, report);
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> Result<FieldFacts> {
        for (const double isovalue : options.isovalues) {
          LODE_TRY(const auto part, extract_one(impl, model, query_of<D>(isovalue, options, report),
                                                options, surface, report, progress));
          add_part(part, report);
          if (!part.has_isovalues) add_isovalue(isovalue, options, surface);
        }
        const bool closes = options.border == Border::closed;
        return FieldFacts{model.info.grid,
                          closes && model.has_holes() && model.has_removed_border_cell(),
                          model.value({})};
      },
      *held);
}

}  // namespace lode
