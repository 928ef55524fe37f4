#include "lode/api/lined_hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "lode/api/terrain_breaklines.h"
#include "lode/core/expects.h"
#include "lode/mappers/tin_lines.h"
#include "lode/models/terrain/delaunay_selector/selector.h"

namespace lode {

using triangle_hierarchy::FirstMesh;
using triangle_hierarchy::Hierarchy;

namespace {

using Line = std::array<LatticePoint, 2>;

bool is_before(const Line& a, const Line& b) {
  return a[0] != b[0] ? is_before_in_rows(a[0], b[0]) : is_before_in_rows(a[1], b[1]);
}

/// In rows, each from its end that comes first.
std::vector<Line> sorted(std::vector<Line> lines) {
  for (Line& line : lines)
    if (is_before_in_rows(line[1], line[0])) std::swap(line[0], line[1]);
  std::ranges::sort(lines, is_before);
  return lines;
}

std::vector<Line> lines_of(const Hierarchy& hierarchy) {
  std::vector<Line> lines;
  lines.reserve(hierarchy.lines.size());
  for (const auto& [a, b] : hierarchy.lines)
    lines.push_back({hierarchy.vertices[a], hierarchy.vertices[b]});
  return lines;
}

}  // namespace

Result<FirstMesh> first_mesh(const PointTerrain& lined,
                             const triangle_hierarchy::ReferenceSurface& surface, double tolerance,
                             Progress& progress) {
  LODE_TRY(
      const delaunay_selector::Selection selected,
      select_points(lined.points, lined.domain,
                    {.max_error = tolerance, .order = delaunay_selector::InsertionOrder::strict},
                    progress));
  const delaunay::Tin& tin = selected.tin;
  FirstMesh first;
  first.patch.triangles = tin.triangles;
  first.patch.places.reserve(tin.vertices.size());
  for (std::size_t v = 0; v < tin.vertices.size(); ++v)
    first.patch.places.push_back({surface.fine(tin.vertices[v]), tin.heights[v]});
  const auto vertex_at = [&](LatticePoint sample) {
    const auto found = std::ranges::lower_bound(tin.vertices, sample, is_before_in_rows);
    LODE_EXPECTS(found != tin.vertices.end() && *found == sample);
    return static_cast<std::uint32_t>(found - tin.vertices.begin());
  };
  first.lines.reserve(lined.domain.lines.size());
  for (const auto& [a, b] : lined.domain.lines)
    first.lines.push_back({vertex_at(lined.points.nodes[a]), vertex_at(lined.points.nodes[b])});
  return first;
}

Result<void> check_lines(const Hierarchy& hierarchy, Progress& progress, VerifyReport& report) {
  if (hierarchy.lines.empty()) return {};
  const std::vector<Line> lines = lines_of(hierarchy);
  std::uint64_t n_broken = 0;
  for (int level = 0; level < hierarchy.n_levels(); ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    const delaunay::Tin tin = tin_of_level(hierarchy, level, delaunay::TinLinks::left_out);
    n_broken += TinLines(tin.triangles, tin.vertices, lines).n_broken();
  }
  report.add("lines are edges of all levels, or chains of them",
             lines.size() * static_cast<std::uint64_t>(hierarchy.n_levels()), n_broken, "");
  return {};
}

Result<void> compare_lines(const Hierarchy& hierarchy, const PointTerrain& lined,
                           VerifyReport& report) {
  const HeightFrame& frame = hierarchy.frame;
  if (lined.points.n_columns != frame.n_columns || lined.points.n_rows != frame.n_rows)
    return fail(
        "expected lines of features alone, between the model's {} x {} samples, got a lattice of "
        "{} x {}",
        frame.n_columns, frame.n_rows, lined.points.n_columns, lined.points.n_rows);
  std::vector<Line> wanted;
  wanted.reserve(lined.domain.lines.size());
  const auto fine = [&](std::uint32_t point) {
    const LatticePoint p = lined.points.nodes[point];
    return LatticePoint{p.x << hierarchy.bits, p.y << hierarchy.bits};
  };
  for (const auto& [a, b] : lined.domain.lines) wanted.push_back({fine(a), fine(b)});
  wanted = sorted(std::move(wanted));
  const std::vector<Line> own = sorted(lines_of(hierarchy));
  std::vector<Line> other;
  std::ranges::set_symmetric_difference(own, wanted, std::back_inserter(other), is_before);
  const char* name =
      hierarchy.is_of_points ? "lines are those of the terrain" : "lines are those of the features";
  report.add(name, wanted.size(), other.size(),
             other.empty() ? ""
                           : fmt::format("{} here, {} there, {} of one alone", own.size(),
                                         wanted.size(), other.size()));
  return {};
}

}  // namespace lode
