#include "lode/models/terrain/delaunay_pyramid/level_reader.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "lode/delaunay/lattice.h"
#include "lode/models/terrain/delaunay_pyramid/file_layout.h"
#include "lode/models/terrain/insertions/file_head.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticePoint;
using terrain_file::read_column;
using Triple = std::array<std::uint32_t, 3>;

std::string place_in(const store::Reader& reader, std::size_t level) {
  return fmt::format("{}: level {}", reader.path(), level);
}

Result<void> check_places(const std::string& path, const std::vector<LatticePoint>& vertices) {
  const auto row = [](LatticePoint p) { return std::pair(p.y, p.x); };
  std::vector<LatticePoint> sorted = vertices;
  std::ranges::sort(sorted, {}, row);
  const auto twice = std::ranges::adjacent_find(sorted);
  if (twice != sorted.end())
    return fail("{}: expected vertices at places of their own, got two in column {}, row {}", path,
                twice->x, twice->y);
  return {};
}

Result<std::vector<Triple>> read_triples(const store::Reader& reader, Column column,
                                         std::size_t level, std::uint64_t n) {
  LODE_TRY(const auto numbers, read_column<std::uint32_t>(reader, key_of(column, level), 3 * n));
  std::vector<Triple> triples(n);
  for (std::size_t i = 0; i < numbers.size(); ++i) triples[i / 3][i % 3] = numbers[i];
  return triples;
}

Result<void> read_triangles(const store::Reader& reader, std::size_t level, Pyramid& pyramid) {
  const std::uint32_t n = pyramid.head.n_kept[level];
  const std::uint32_t n_vertices = pyramid.head.vertices_until[level];
  PyramidLevel& kept = pyramid.levels[level];
  LODE_TRY(kept.triangles, read_triples(reader, Column::corners, level, n));
  for (std::size_t t = 0; t < kept.triangles.size(); ++t) {
    const Triple& corner = kept.triangles[t];
    for (const std::uint32_t v : corner)
      if (v >= n_vertices)
        return fail("{}: triangle {}: expected one of {} vertices, got {}", place_in(reader, level),
                    t, n_vertices, v);
    if (delaunay::doubled_area(pyramid.vertices[corner[0]], pyramid.vertices[corner[1]],
                               pyramid.vertices[corner[2]]) <= 0)
      return fail("{}: triangle {}: expected corners that turn left, got {}, {}, {}",
                  place_in(reader, level), t, corner[0], corner[1], corner[2]);
  }
  LODE_TRY(const auto halves, read_column<std::uint16_t>(reader, key_of(Column::error, level), n));
  kept.errors.reserve(halves.size());
  for (const std::uint16_t half : halves) {
    kept.errors.push_back(insertions::to_error(half));
    if (kept.errors.back() < 0)
      return fail("{}: expected finite errors >= 0, got the upper half {:#x}",
                  place_in(reader, level), half);
  }
  return {};
}

Result<void> read_deaths(const store::Reader& reader, std::size_t level, Pyramid& pyramid) {
  const std::size_t n_levels = pyramid.head.n_levels();
  LODE_TRY(const auto deaths, read_column<std::uint16_t>(reader, key_of(Column::death, level),
                                                         pyramid.head.n_kept[level]));
  for (const std::uint16_t death : deaths)
    if (death <= level || death > n_levels)
      return fail("{}: expected triangles that end with a level from {} to {}, got {}",
                  place_in(reader, level), level + 1, n_levels, death);
  pyramid.levels[level].deaths.assign(deaths.begin(), deaths.end());
  return {};
}

/// How many triangles those of a level may be linked to: 0: it has none.
std::uint32_t n_linked_to(const Pyramid& pyramid, std::size_t level, std::size_t triangle) {
  const std::size_t to =
      pyramid.head.is_of_lists() ? pyramid.levels[level].deaths[triangle] : level + 1;
  return to < pyramid.head.n_levels() ? pyramid.head.n_kept[to] : 0;
}

Result<void> read_links_of(const store::Reader& reader, std::size_t level, Pyramid& pyramid) {
  const std::uint64_t n = pyramid.head.n_links[level];
  LODE_TRY(const auto counts, read_column<std::uint32_t>(reader, key_of(Column::n_links, level),
                                                         pyramid.head.n_kept[level]));
  LinkLists& links = pyramid.levels[level].links;
  LODE_TRY(links.items, read_column<std::uint32_t>(reader, key_of(Column::links, level), n));
  links.first.reserve(counts.size() + 1);
  links.first.push_back(0);
  for (std::size_t t = 0; t < counts.size(); ++t) {
    const std::uint32_t n_others = n_linked_to(pyramid, level, t);
    const std::uint64_t first = links.first.back();
    if ((counts[t] > 0) != (n_others > 0) || counts[t] > n_others || counts[t] > n - first)
      return fail("{}: triangle {}: expected {} of {} triangles, got {} links",
                  place_in(reader, level), t,
                  n_others > 0 ? "links to one or more" : "no links to any", n_others, counts[t]);
    links.first.push_back(first + counts[t]);
    const auto of = links.of(static_cast<std::uint32_t>(t));
    if (std::ranges::adjacent_find(of, std::greater_equal()) != of.end() ||
        (!of.empty() && of.back() >= n_others))
      return fail("{}: triangle {}: expected links that ascend, below {}, got others",
                  place_in(reader, level), t, n_others);
  }
  LODE_TRY(const auto firsts, read_column<std::uint64_t>(reader, key_of(Column::first_links, level),
                                                         n_parts(pyramid.head.n_kept[level])));
  for (std::size_t i = 0; i < firsts.size(); ++i)
    if (firsts[i] != links.first[i * terrain_file::kPart])
      return fail("{}: expected the links of triangle {} from {}, got {}", place_in(reader, level),
                  i * terrain_file::kPart, links.first[i * terrain_file::kPart], firsts[i]);
  if (links.first.back() != n)
    return fail("{}: expected {} links, got {}", place_in(reader, level), n, links.first.back());
  return {};
}

}  // namespace

Result<void> read_vertices(const store::Reader& reader, std::size_t end_level, Pyramid& pyramid) {
  const PyramidHead& head = pyramid.head;
  const HeightFrame& frame = head.source.frame;
  for (std::size_t level = 0; level < end_level; ++level) {
    const std::uint64_t n = head.vertices_until[level] - head.first_vertex(level);
    LODE_TRY(const auto xs, read_column<std::int32_t>(reader, key_of(Column::x, level), n));
    LODE_TRY(const auto ys, read_column<std::int32_t>(reader, key_of(Column::y, level), n));
    for (std::size_t i = 0; i < xs.size(); ++i) {
      if (xs[i] < 0 || ys[i] < 0 || xs[i] >= frame.n_columns || ys[i] >= frame.n_rows)
        return fail("{}: expected vertices in {} x {}, got column {}, row {}",
                    place_in(reader, level), frame.n_columns, frame.n_rows, xs[i], ys[i]);
      pyramid.vertices.push_back({xs[i], ys[i]});
    }
    LODE_TRY(const auto heights,
             terrain_file::read_heights(reader, key_of(Column::height, level), head.height_type, n,
                                        head.source.range));
    pyramid.heights.insert(pyramid.heights.end(), heights.begin(), heights.end());
  }
  return check_places(reader.path(), pyramid.vertices);
}

Result<void> read_lines(const store::Reader& reader, Pyramid& pyramid) {
  const std::uint64_t n = pyramid.head.n_lines;
  LODE_TRY(const auto ends, read_column<std::uint32_t>(reader, key_of(Column::lines, 0), 2 * n));
  for (std::size_t i = 0; i < ends.size(); i += 2) {
    const std::array<std::uint32_t, 2> line{ends[i], ends[i + 1]};
    const bool follows = pyramid.lines.empty() || pyramid.lines.back() < line;
    if (!follows || line[0] >= line[1] || line[1] >= pyramid.head.vertices_until[0])
      return fail("{}: expected lines between two of {} vertices, in order, got {} to {}",
                  reader.path(), pyramid.head.vertices_until[0], line[0], line[1]);
    pyramid.lines.push_back(line);
  }
  return {};
}

Result<void> read_level(const store::Reader& reader, std::size_t level, ReadLinks links,
                        Pyramid& pyramid) {
  LODE_CHECK(read_triangles(reader, level, pyramid));
  if (pyramid.head.is_of_lists()) {
    LODE_CHECK(read_deaths(reader, level, pyramid));
  } else {
    LODE_TRY(pyramid.levels[level].twins,
             read_triples(reader, Column::twins, level, pyramid.head.n_kept[level]));
  }
  if (links == ReadLinks::no || !has_links(pyramid.head.encoding)) return {};
  return read_links_of(reader, level, pyramid);
}

}  // namespace lode::delaunay_pyramid
