#include <bit>
#include <utility>

#include "lode/models/terrain/delaunay_pyramid/file_layout.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_file.h"
#include "lode/store/bytes.h"
#include "lode/store/writer.h"

namespace lode::delaunay_pyramid {
namespace {

using terrain_file::append_column;

std::vector<std::byte> encode_metadata(const PyramidHead& head) {
  store::ByteWriter out;
  out.write(kLayout);
  out.write(static_cast<std::uint8_t>(head.source.is_of_points));
  terrain_file::write(out, head.source);
  out.write(head.max_error);
  terrain_file::write_levels(out, head.tolerances);
  out.write(static_cast<std::uint8_t>(head.height_type));
  out.write(head.n_lines);
  out.write_all(std::span<const std::uint32_t>(head.vertices_until));
  out.write_all(std::span<const std::uint32_t>(head.n_in_mesh));
  out.write_all(std::span<const std::uint32_t>(head.n_kept));
  out.write_all(std::span<const std::uint64_t>(head.n_links));
  for (const MeshFacts& facts : head.facts) {
    out.write(facts.largest_error);
    out.write(facts.smallest_angle);
    out.write(facts.median_angle);
  }
  return std::move(out).take();
}

Result<void> append_vertices(const Pyramid& pyramid, std::size_t level, store::Writer& writer) {
  const std::uint32_t first = pyramid.head.first_vertex(level);
  const std::uint32_t n = pyramid.head.vertices_until[level] - first;
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::x, level), n, [&](std::uint64_t i) { return pyramid.vertices[first + i].x; },
      writer));
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::y, level), n, [&](std::uint64_t i) { return pyramid.vertices[first + i].y; },
      writer));
  return terrain_file::append_heights(key_of(Column::height, level), pyramid.head.height_type,
                                      std::span(pyramid.heights).subspan(first, n), writer);
}

/// Three numbers by triangle.
Result<void> append_triples(Column column, std::size_t level,
                            const std::vector<std::array<std::uint32_t, 3>>& triples,
                            store::Writer& writer) {
  return append_column<std::uint32_t>(
      key_of(column, level), 3 * std::uint64_t{triples.size()},
      [&](std::uint64_t i) { return triples[i / 3][i % 3]; }, writer);
}

Result<void> append_links(const LinkLists& links, std::size_t level, store::Writer& writer) {
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::n_links, level), links.first.size() - 1,
      [&](std::uint64_t i) {
        return static_cast<std::uint32_t>(links.first[i + 1] - links.first[i]);
      },
      writer));
  const std::uint64_t n = links.first.size() - 1;
  LODE_CHECK(append_column<std::uint64_t>(
      key_of(Column::first_links, level), n_parts(n),
      [&](std::uint64_t i) { return links.first[i * terrain_file::kPart]; }, writer));
  return append_column<std::uint32_t>(
      key_of(Column::links, level), links.items.size(),
      [&](std::uint64_t i) { return links.items[i]; }, writer);
}

Result<void> append_level(const Pyramid& pyramid, std::size_t level, store::Writer& writer) {
  const PyramidLevel& kept = pyramid.levels[level];
  const std::uint64_t n = kept.triangles.size();
  LODE_CHECK(append_vertices(pyramid, level, writer));
  LODE_CHECK(append_triples(Column::corners, level, kept.triangles, writer));
  LODE_CHECK(append_column<std::uint16_t>(
      key_of(Column::error, level), n,
      [&](std::uint64_t i) {
        return static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(kept.errors[i]) >> 16);
      },
      writer));
  if (pyramid.head.is_of_lists())
    LODE_CHECK(append_column<std::uint16_t>(
        key_of(Column::death, level), n,
        [&](std::uint64_t i) { return static_cast<std::uint16_t>(kept.deaths[i]); }, writer));
  else
    LODE_CHECK(append_triples(Column::twins, level, kept.twins, writer));
  return has_links(pyramid.head.encoding) ? append_links(kept.links, level, writer)
                                          : Result<void>{};
}

}  // namespace

Result<std::uint64_t> save(const Pyramid& pyramid, const std::string& path, Progress& progress) {
  const auto encoding = static_cast<std::size_t>(pyramid.head.encoding);
  LODE_TRY(auto writer,
           store::Writer::create(path, kModelNames[encoding], encode_metadata(pyramid.head)));
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::lines, 0), 2 * std::uint64_t{pyramid.lines.size()},
      [&](std::uint64_t i) { return pyramid.lines[i / 2][i % 2]; }, writer));
  for (std::size_t level = 0; level < pyramid.head.n_levels(); ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(append_level(pyramid, level, writer));
  }
  return writer.finish(progress);
}

}  // namespace lode::delaunay_pyramid
