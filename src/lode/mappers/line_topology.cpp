#include "lode/mappers/line_topology.h"

namespace lode {
namespace {

void add(Offenders& offenders, std::uint32_t vertex) {
  if (offenders.count++ == 0) offenders.first = {vertex, vertex};
}

}  // namespace

void check_line_vertices(const Surface& surface, const VertexCorners& corners,
                         TopologyReport& report, std::vector<std::uint8_t>& is_boundary) {
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    std::uint32_t n_starting = 0;
    std::uint32_t n_ending = 0;
    for (const std::uint32_t corner : corners.of(v)) {
      const auto& line = surface.lines[corner / 2];
      if (line[0] != line[1]) ++(corner % 2 == 0 ? n_starting : n_ending);
    }
    const std::uint32_t n_lines = n_starting + n_ending;
    if (n_lines > 0) ++report.n_used_vertices;
    if (corners.of(v).empty()) add(report.isolated_vertices, v);
    if (n_lines > 2) add(report.non_manifold_vertices, v);
    if (n_lines == 2 && n_starting != 1) add(report.inconsistent_edges, v);
    if (n_lines == 1) {
      ++report.n_boundary_edges;
      is_boundary[v] = 1;
    }
  }
  for (const auto& line : surface.lines)
    if (line[0] != line[1]) ++report.n_edges;
}

}  // namespace lode
