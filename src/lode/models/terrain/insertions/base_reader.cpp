#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/terrain/insertions/base_check.h"
#include "lode/models/terrain/insertions/file_head.h"

namespace lode::insertions {
namespace {

using delaunay::LatticePoint;
using terrain_file::read_column;

Result<void> read_vertices(const store::Reader& reader, const FileHead& head, History& history) {
  const std::uint64_t n = head.n_base_vertices;
  LODE_TRY(const auto xs, read_column<std::int32_t>(reader, key_of(Column::x), n));
  LODE_TRY(const auto ys, read_column<std::int32_t>(reader, key_of(Column::y), n));
  const HeightFrame& frame = history.frame;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    if (xs[i] < 0 || ys[i] < 0 || xs[i] >= frame.n_columns || ys[i] >= frame.n_rows)
      return fail("{}: expected vertices in {} x {}, got column {}, row {}", reader.path(),
                  frame.n_columns, frame.n_rows, xs[i], ys[i]);
    history.vertices.push_back({xs[i], ys[i]});
  }
  const auto row = [](LatticePoint p) { return std::pair(p.y, p.x); };
  std::vector<LatticePoint> sorted = history.vertices;
  std::ranges::sort(sorted, {}, row);
  const auto twice = std::ranges::adjacent_find(sorted);
  if (twice != sorted.end())
    return fail(
        "{}: expected vertices of the base at places of their own, got two in column {}, "
        "row {}",
        reader.path(), twice->x, twice->y);
  history.n_base_vertices = head.n_base_vertices;
  LODE_TRY(history.heights,
           terrain_file::read_heights(reader, key_of(Column::height), head.type, n, history.range));
  return {};
}

/// Triangles that turn left, by vertices, which they come to in the order of these.
Result<void> read_triangles(const store::Reader& reader, const FileHead& head, History& history) {
  const std::uint64_t n = head.n_base_triangles;
  LODE_TRY(const auto corners, read_column<std::uint32_t>(reader, key_of(Column::corners), 3 * n));
  LODE_TRY(const auto errors, read_column<std::uint16_t>(reader, key_of(Column::error), n));
  std::uint32_t n_met = 0;
  for (std::size_t t = 0; t < n; ++t) {
    Triangle triangle{.corner = {}, .death = kNone, .error = to_error(errors[t])};
    LatticeCorners p;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t vertex = corners[3 * t + i];
      if (vertex >= head.n_base_vertices)
        return fail("{}: expected one of {} vertices of the base, got {}", reader.path(),
                    head.n_base_vertices, vertex);
      if (vertex > n_met)
        return fail("{}: expected the {} vertices of the base first, as its triangles come to them",
                    reader.path(), head.n_base_vertices);
      n_met += vertex == n_met ? 1 : 0;
      p[i] = history.vertices[vertex];
      triangle.corner[i] = vertex;
    }
    if (delaunay::doubled_area(p[0], p[1], p[2]) <= 0)
      return fail(
          "{}: expected triangles that turn left, got number {} of the base, which does not",
          reader.path(), t);
    if (triangle.error < 0)
      return fail("{}: expected finite errors >= 0, got the upper half {:#x}", reader.path(),
                  errors[t]);
    history.triangles.push_back(triangle);
  }
  if (n_met != head.n_base_vertices)
    return fail("{}: expected the {} vertices of the base first, as its triangles come to them",
                reader.path(), head.n_base_vertices);
  return {};
}

Result<void> check_cover(const std::string& path, const History& history) {
  std::vector<std::array<std::uint32_t, 3>> corners;
  std::vector<LatticeCorners> places;
  for (const Triangle& triangle : history.triangles) {
    corners.push_back(triangle.corner);
    const auto& [a, b, c] = triangle.corner;
    places.push_back({history.vertices[a], history.vertices[b], history.vertices[c]});
  }
  if (history.is_of_points ? !cover_part_once(history.vertices, corners)
                           : !cover_cells_once(places))
    return fail("{}: expected a base that covers {} once, edge to edge, got triangles that do not",
                path, history.is_of_points ? "its domain" : "cells");
  if (rule_of(history.model) != delaunay::InsertionRule::delaunay) return {};
  delaunay::PointMesh mesh(delaunay::ListedNodes(history.vertices), corners);
  mesh.cut(history.lines);
  if (!mesh.is_delaunay())
    return fail("{}: expected a base that is Delaunay, got edges that are not", path);
  return {};
}

Result<void> read_lines(const store::Reader& reader, const FileHead& head, History& history) {
  LODE_TRY(const auto ends, read_column<std::uint32_t>(reader, key_of(Column::lines),
                                                       2 * std::uint64_t{head.n_lines}));
  using Ends = std::array<std::uint32_t, 2>;
  std::vector<Ends> edges;
  for (const Triangle& triangle : history.triangles)
    for (std::size_t i = 0; i < 3 && !ends.empty(); ++i)
      edges.push_back({triangle.corner[i], triangle.corner[(i + 1) % 3]});
  std::ranges::sort(edges);
  for (std::size_t i = 0; i < ends.size(); i += 2) {
    const Ends line{ends[i], ends[i + 1]};
    const bool follows = history.lines.empty() || history.lines.back() < line;
    if (!follows || line[0] > line[1] || !std::ranges::binary_search(edges, line) ||
        !std::ranges::binary_search(edges, Ends{line[1], line[0]}))
      return fail(
          "{}: expected fixed edges between two triangles of the base, in order, got {} to {}",
          reader.path(), line[0], line[1]);
    history.lines.push_back(line);
  }
  return {};
}

}  // namespace

Result<void> read_base(const store::Reader& reader, const FileHead& head, History& history) {
  LODE_CHECK(read_vertices(reader, head, history));
  LODE_CHECK(read_triangles(reader, head, history));
  LODE_CHECK(read_lines(reader, head, history));
  LODE_CHECK(check_cover(reader.path(), history));
  history.first_made = {head.n_base_triangles};
  history.first_removed = {0};
  return {};
}

}  // namespace lode::insertions
