#include "lode/mappers/surface_topology.h"

#include <algorithm>
#include <compare>
#include <numeric>
#include <span>

#include "lode/mappers/coincident_vertices.h"
#include "lode/mappers/line_topology.h"
#include "lode/mappers/triangle_intersection.h"
#include "lode/mappers/vertex_corners.h"

namespace lode {
namespace {

using Pair = std::array<std::uint32_t, 2>;

constexpr std::size_t kVerticesPerChunk = 4096;

/// One end of an edge as its vertex sees it.
struct Spoke {
  std::uint32_t other = 0;     ///< The vertex at the far end.
  std::uint32_t triangle = 0;  ///< Which of the vertex's triangles, counted from 0.
  bool is_outgoing = false;    ///< The triangle runs from the vertex to the far end.

  friend auto operator<=>(const Spoke&, const Spoke&) = default;
};

void add(Offenders& offenders, const Pair& offender) {
  if (offenders.count++ == 0) offenders.first = offender;
}

void append(Offenders& offenders, const Offenders& later) {
  if (offenders.count == 0) offenders.first = later.first;
  offenders.count += later.count;
}

std::uint32_t find_root(std::span<std::uint32_t> parents, std::uint32_t i) {
  while (parents[i] != i) {
    parents[i] = parents[parents[i]];
    i = parents[i];
  }
  return i;
}

/// Roots are the lowest members, so that they do not depend on the order of joining.
void join(std::span<std::uint32_t> parents, std::uint32_t a, std::uint32_t b) {
  a = find_root(parents, a);
  b = find_root(parents, b);
  parents[std::max(a, b)] = std::min(a, b);
}

bool repeats_vertex(const std::array<std::uint32_t, 3>& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// The spokes of vertex v, sorted; returns how many triangles they come from.
std::uint32_t gather_spokes(const Surface& surface, std::span<const std::uint32_t> corners,
                            std::vector<Spoke>& spokes) {
  spokes.clear();
  std::uint32_t n_triangles = 0;
  for (const std::uint32_t corner : corners) {
    const auto& t = surface.triangles[corner / 3];
    if (repeats_vertex(t)) continue;
    spokes.push_back({t[(corner + 1) % 3], n_triangles, true});
    spokes.push_back({t[(corner + 2) % 3], n_triangles, false});
    ++n_triangles;
  }
  std::sort(spokes.begin(), spokes.end());
  return n_triangles;
}

/// Per vertex, what the components need to know.
struct VertexCounts {
  std::vector<std::uint32_t> edges;           ///< To higher vertices.
  std::vector<std::uint32_t> boundary_edges;  ///< Of these, with one triangle.
  std::vector<std::uint8_t> is_used;
  std::vector<std::uint8_t> is_boundary;
  std::vector<Pair> boundary;  ///< Edges with one triangle.
};

/// What one chunk of vertices adds to the report.
struct Chunk {
  Offenders non_manifold_edges;
  Offenders inconsistent_edges;
  Offenders non_manifold_vertices;
  Offenders isolated_vertices;
  std::vector<Pair> boundary_edges;
};

class VertexExaminer {
 public:
  VertexExaminer(const Surface& surface, const VertexCorners& corners, VertexCounts& counts)
      : surface_(surface), corners_(corners), counts_(counts) {}

  void examine(std::uint32_t v, Chunk& chunk) {
    if (corners_.of(v).empty()) add(chunk.isolated_vertices, {v, v});
    const std::uint32_t n_triangles = gather_spokes(surface_, corners_.of(v), spokes_);
    if (n_triangles == 0) return;
    counts_.is_used[v] = 1;
    fans_.resize(n_triangles);
    std::iota(fans_.begin(), fans_.end(), std::uint32_t{0});
    for (std::size_t begin = 0; begin < spokes_.size();) {
      std::size_t end = begin + 1;
      while (end < spokes_.size() && spokes_[end].other == spokes_[begin].other) ++end;
      examine_edge(v, std::span(spokes_).subspan(begin, end - begin), chunk);
      begin = end;
    }
    for (std::uint32_t i = 0; i < n_triangles; ++i) {
      if (find_root(fans_, i) == 0) continue;
      add(chunk.non_manifold_vertices, {v, v});
      break;
    }
  }

 private:
  void examine_edge(std::uint32_t v, std::span<const Spoke> edge, Chunk& chunk) {
    for (const Spoke& spoke : edge) join(fans_, edge.front().triangle, spoke.triangle);
    const std::uint32_t other = edge.front().other;
    if (edge.size() == 1) counts_.is_boundary[v] = 1;
    if (other < v) return;
    ++counts_.edges[v];
    if (edge.size() == 1) {
      ++counts_.boundary_edges[v];
      chunk.boundary_edges.push_back(edge.front().is_outgoing ? Pair{v, other} : Pair{other, v});
    } else if (edge.size() > 2) {
      add(chunk.non_manifold_edges, {v, other});
    } else if (edge[0].is_outgoing == edge[1].is_outgoing) {
      add(chunk.inconsistent_edges, {v, other});
    }
  }

  const Surface& surface_;
  const VertexCorners& corners_;
  VertexCounts& counts_;
  std::vector<Spoke> spokes_;
  std::vector<std::uint32_t> fans_;
};

std::vector<Chunk> examine_vertices(const Surface& surface, Threads threads, VertexCounts& counts) {
  const std::size_t n = surface.positions.size();
  const VertexCorners corners = find_vertex_corners(surface.triangles, n);
  counts.edges.assign(n, 0);
  counts.boundary_edges.assign(n, 0);
  counts.is_used.assign(n, 0);
  counts.is_boundary.assign(n, 0);
  std::vector<Chunk> chunks((n + kVerticesPerChunk - 1) / kVerticesPerChunk);
  parallel_for(chunks.size(), threads, 1, [&](std::size_t c, int) {
    VertexExaminer examiner(surface, corners, counts);
    const std::size_t end = std::min(n, (c + 1) * kVerticesPerChunk);
    for (std::size_t v = c * kVerticesPerChunk; v < end; ++v)
      examiner.examine(static_cast<std::uint32_t>(v), chunks[c]);
  });
  return chunks;
}

void check_triangle_vertices(const Surface& surface, Threads threads, TopologyReport& report,
                             VertexCounts& counts) {
  for (const Chunk& chunk : examine_vertices(surface, threads, counts)) {
    append(report.non_manifold_edges, chunk.non_manifold_edges);
    append(report.inconsistent_edges, chunk.inconsistent_edges);
    append(report.non_manifold_vertices, chunk.non_manifold_vertices);
    append(report.isolated_vertices, chunk.isolated_vertices);
    counts.boundary.insert(counts.boundary.end(), chunk.boundary_edges.begin(),
                           chunk.boundary_edges.end());
  }
  report.n_boundary_edges = counts.boundary.size();
  for (std::size_t v = 0; v < counts.edges.size(); ++v) {
    report.n_edges += counts.edges[v];
    report.n_used_vertices += counts.is_used[v];
  }
}

/// Lines know their edges and used vertices by simplex: the counts that make components work.
void count_lines(const Surface& surface, const TopologyReport& report, VertexCounts& counts) {
  counts.edges.assign(surface.positions.size(), 0);
  counts.boundary_edges.assign(surface.positions.size(), 0);
  counts.is_used.assign(surface.positions.size(), 0);
  for (const auto& line : surface.lines) {
    if (line[0] == line[1]) continue;
    ++counts.edges[line[0]];
    counts.is_used[line[0]] = counts.is_used[line[1]] = 1;
  }
  if (report.n_boundary_edges == 0) return;
  for (std::size_t v = 0; v < counts.is_boundary.size(); ++v)
    counts.boundary_edges[v] = counts.is_boundary[v];
}

/// The lowest vertex of each vertex's component.
std::vector<std::uint32_t> find_components(const Surface& surface) {
  std::vector<std::uint32_t> parents(surface.positions.size());
  std::iota(parents.begin(), parents.end(), std::uint32_t{0});
  for (const auto& t : surface.triangles) {
    if (repeats_vertex(t)) continue;
    join(parents, t[0], t[1]);
    join(parents, t[0], t[2]);
  }
  for (const auto& line : surface.lines) join(parents, line[0], line[1]);
  for (std::uint32_t v = 0; v < parents.size(); ++v) parents[v] = find_root(parents, v);
  return parents;
}

/// The loops that boundary edges make. `numbers`: of the components, by vertex.
void count_loops(const std::vector<Pair>& boundary, const std::vector<std::uint32_t>& numbers,
                 TopologyReport& report) {
  if (boundary.empty()) return;
  std::vector<std::uint32_t> parents(numbers.size());
  std::iota(parents.begin(), parents.end(), std::uint32_t{0});
  for (const Pair& edge : boundary) join(parents, edge[0], edge[1]);
  std::vector<std::uint32_t> loops;
  loops.reserve(boundary.size());
  for (const Pair& edge : boundary) loops.push_back(find_root(parents, edge[0]));
  std::sort(loops.begin(), loops.end());
  loops.erase(std::unique(loops.begin(), loops.end()), loops.end());
  for (const std::uint32_t v : loops) ++report.components[numbers[v]].n_boundary_loops;
}

void report_components(const Surface& surface, const VertexCounts& counts, TopologyReport& report) {
  std::vector<std::uint32_t> numbers = find_components(surface);
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (counts.is_used[v] == 0) continue;
    // A component's lowest vertex comes first and gives it its number.
    if (numbers[v] == v) {
      numbers[v] = static_cast<std::uint32_t>(report.components.size());
      report.components.emplace_back();
    } else {
      numbers[v] = numbers[numbers[v]];
    }
    ComponentReport& component = report.components[numbers[v]];
    component.euler_number += 1 - std::int64_t{counts.edges[v]};
    component.n_boundary_edges += counts.boundary_edges[v];
  }
  for (const auto& t : surface.triangles) {
    if (repeats_vertex(t)) continue;
    ++report.components[numbers[t[0]]].n_simplices;
    ++report.components[numbers[t[0]]].euler_number;
  }
  for (const auto& line : surface.lines)
    if (line[0] != line[1]) ++report.components[numbers[line[0]]].n_simplices;
  count_loops(counts.boundary, numbers, report);
  for (const ComponentReport& c : report.components) report.euler_number += c.euler_number;
}

void check_shapes(const Surface& surface, TopologyReport& report) {
  const auto& p = surface.positions;
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& t = surface.triangles[i];
    if (repeats_vertex(t) || has_zero_area(p[t[0]], p[t[1]], p[t[2]]))
      add(report.degenerate_simplices, {i, i});
  }
  for (std::uint32_t i = 0; i < surface.lines.size(); ++i)
    if (p[surface.lines[i][0]] == p[surface.lines[i][1]]) add(report.degenerate_simplices, {i, i});
}

void check_duplicates(const Surface& surface, const TopologyOptions& options,
                      const std::vector<std::uint8_t>& is_boundary, TopologyReport& report) {
  const std::vector<std::uint32_t> lowest = find_coincident_vertices(surface.positions);
  std::vector<std::uint8_t> all_boundary = is_boundary;
  for (std::size_t v = 0; v < lowest.size(); ++v)
    if (is_boundary[v] == 0) all_boundary[lowest[v]] = 0;
  for (std::uint32_t v = 0; v < lowest.size(); ++v) {
    if (lowest[v] == v) continue;
    const bool is_twin =
        all_boundary[lowest[v]] != 0 && (!options.may_pinch || options.may_pinch(v));
    if (is_twin)
      ++report.n_twins;
    else
      add(report.duplicate_vertices, {lowest[v], v});
  }
}

}  // namespace

bool TopologyReport::is_clean_manifold() const {
  return non_manifold_edges.count == 0 && inconsistent_edges.count == 0 &&
         non_manifold_vertices.count == 0 && isolated_vertices.count == 0 &&
         degenerate_simplices.count == 0 && duplicate_vertices.count == 0;
}

ComponentTypes component_types(const TopologyReport& report) {
  ComponentTypes types;
  types.reserve(report.components.size());
  for (const ComponentReport& c : report.components)
    types.push_back({c.euler_number, static_cast<std::int64_t>(c.n_boundary_loops)});
  std::sort(types.begin(), types.end());
  return types;
}

TopologyReport check_topology(const Surface& surface, const TopologyOptions& options) {
  TopologyReport report;
  report.n_simplices = surface.triangles.size() + surface.lines.size();
  VertexCounts counts;
  if (surface.lines.empty()) {
    check_triangle_vertices(surface, options.threads, report, counts);
  } else {
    counts.is_boundary.assign(surface.positions.size(), 0);
    const auto corners = find_vertex_corners(surface.lines, surface.positions.size());
    check_line_vertices(surface, corners, report, counts.is_boundary);
    count_lines(surface, report, counts);
  }
  report_components(surface, counts, report);
  check_shapes(surface, report);
  check_duplicates(surface, options, counts.is_boundary, report);
  return report;
}

std::vector<std::array<std::uint32_t, 2>> find_boundary_edges(const Surface& surface,
                                                              Threads threads) {
  std::vector<Pair> edges;
  if (surface.lines.empty()) {
    VertexCounts counts;
    for (const Chunk& chunk : examine_vertices(surface, threads, counts))
      edges.insert(edges.end(), chunk.boundary_edges.begin(), chunk.boundary_edges.end());
    return edges;
  }
  TopologyReport report;
  std::vector<std::uint8_t> is_boundary(surface.positions.size(), 0);
  const auto corners = find_vertex_corners(surface.lines, surface.positions.size());
  check_line_vertices(surface, corners, report, is_boundary);
  for (std::uint32_t v = 0; v < is_boundary.size(); ++v)
    if (is_boundary[v] != 0) edges.push_back({v, v});
  return edges;
}

}  // namespace lode
