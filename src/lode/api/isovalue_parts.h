#pragma once

// What extraction from memory and from files have in common.

#include <algorithm>
#include <limits>

#include "lode/api/dataset.h"
#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/extract.h"

namespace lode {

/// What the edits after an extraction ask of a field.
struct FieldFacts {
  const RegularGrid& grid;
  bool has_removed_border_cell = false;
  double first_sample = 0;
  bool is_first_weak = false;  ///< The surface has it on the other side (see WeakRegions).
};

/// Adds up what extraction says of one isovalue.
inline void add_part(const diamond::IsosurfaceReport& part, ExtractReport& report) {
  report.achieved_error = std::max(report.achieved_error, part.achieved_error);
  report.coordinate_slack = std::max(report.coordinate_slack, part.coordinate_slack);
  report.style_error = std::max(report.style_error, part.deviation.error);
  report.style_distance = std::max(report.style_distance, part.deviation.distance);
  report.nodes_visited += part.nodes_visited;
  report.seconds.select += part.select_seconds;
  report.seconds.geometry += part.geometry_seconds;
  report.seconds.measure += part.measure_seconds;
}

/// Of several isovalues, gives the vertices that have come last theirs.
inline void add_isovalue(double isovalue, const ExtractOptions& options, Surface& surface) {
  if (options.isovalues.size() == 1) return surface.isovalues.clear();
  const std::size_t first = surface.isovalues.size();
  resize_large(surface.isovalues, surface.positions.size());
  for_each_piece(surface.isovalues.size() - first, options.threads,
                 [&](std::size_t begin, std::size_t end) {
                   fill_by_copies(surface.isovalues.data() + first + begin, end - begin, isovalue);
                 });
}

template <int D>
diamond::IsosurfaceQuery query_of(double isovalue, const ExtractOptions& options,
                                  const ExtractReport& report) {
  return {
      .isovalue = isovalue,
      .tolerance = report.max_error,
      .style = options.style,
      .style_distance = options.style_distance.value_or(std::numeric_limits<double>::infinity()),
      .with_deviation = options.deviation == Deviation::measured,
      .threads = options.threads,
      .with_normals = D == 3 && options.normals == Normals::on,
      .with_isovalues = options.isovalues.size() > 1,
      .replaces = options.isovalues.size() == 1};
}

}  // namespace lode
