#include "lode/api/memory_extraction.h"

#include <optional>

#include "lode/api/distance_extraction.h"
#include "lode/api/topology_extraction.h"
#include "lode/core/stopwatch.h"
#include "lode/models/diamond/cube_deviation.h"

namespace lode {
namespace {

bool measures(const ExtractOptions& options) {
  return options.style == SurfaceStyle::cubes && options.deviation == Deviation::measured;
}

/// How far the surface of a query in the style of cubes is from the level set.
template <int D>
Result<void> measure_style(const diamond::Model<D>& model, const diamond::IsosurfaceQuery& query,
                           ExtractReport& report, Progress& progress) {
  if constexpr (D == 3) {
    const Stopwatch watch;
    LODE_TRY(const auto deviation, diamond::measure_cubes(model, query, progress));
    report.style_error = std::max(report.style_error, deviation.error);
    report.style_distance = std::max(report.style_distance, deviation.distance);
    report.seconds.measure += watch.seconds();
  }
  return {};
}

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
  auto part = diamond::extract_isosurface<D>(model, query, surface, progress);
  if (!part || !measures(options)) return part;
  if (auto done = measure_style(model, query, report, progress); !done) return done.error();
  return part;
}

}  // namespace

Result<FieldFacts> extract_in_memory(const Dataset::Impl& impl, const ExtractOptions& options,
                                     Surface& surface, ExtractReport& report, Progress& progress) {
  LODE_TRY(const auto* const held, impl.model(progress));
  if (options.keep_topology)
    report.topology =
        KeptTopology{.persistence = *options.keep_topology, .is_searched = report.max_error > 0};
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> Result<FieldFacts> {
        for (const double isovalue : options.isovalues) {
          LODE_TRY(const auto part, extract_one(impl, model, query_of<D>(isovalue, options, report),
                                                options, surface, report, progress));
          add_part(part, report);
          add_isovalue(isovalue, options, surface);
        }
        const bool closes = options.border == Border::closed;
        return FieldFacts{model.info.grid,
                          closes && model.has_holes() && model.has_removed_border_cell(),
                          model.value({})};
      },
      *held);
}

}  // namespace lode
