#include <algorithm>
#include <span>

#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/elements.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt {
namespace {

/// Columns are compressed already.
store::EncodedBlock as_block(const std::vector<std::byte>& bytes) {
  return store::encode_block_as(store::Codec::none, {.raw = bytes, .size = 1});
}

/// As differences from the one before.
void add_numbers(std::span<const std::uint32_t> numbers, StreamWriter& out) {
  std::vector<std::uint32_t> column;
  std::uint32_t last = 0;
  for (const std::uint32_t number : numbers)
    column.push_back(store::zigzag(number - std::exchange(last, number)));
  out.add_planes(std::span<const std::uint32_t>(column));
}

std::vector<std::byte> encode_vertices(const HierarchyHead& head, std::size_t first,
                                       std::size_t n) {
  const std::size_t n_fields = head.shape.n_fields;
  std::vector<double> coordinates;
  for (const Vec3d& p : std::span(head.base_positions).subspan(first, n))
    coordinates.insert(coordinates.end(), p.v.begin(), p.v.end());
  StreamWriter out;
  write_numbers(coordinates, 3, head.shape.has_narrow_positions, out);
  write_numbers(std::span(head.base_values).subspan(first * n_fields, n * n_fields), n_fields,
                head.shape.has_narrow_values, out);
  return std::move(out).take();
}

std::vector<std::byte> encode_tetrahedra(const HierarchyHead& head, std::size_t first,
                                         std::size_t n) {
  StreamWriter out;
  std::vector<std::uint32_t> column;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    column.clear();
    for (const Tetrahedron& t : std::span(head.base).subspan(first, n)) column.push_back(t[corner]);
    add_numbers(column, out);
  }
  add_numbers(std::span(head.base_makers).subspan(first, n), out);
  if (head.shape.n_regions > 1) add_numbers(std::span(head.base_regions).subspan(first, n), out);
  return std::move(out).take();
}

Result<void> append_base(const HierarchyHead& head, store::Writer& writer) {
  const auto append = [&](Kind kind, std::size_t n, const auto& encode) -> Result<void> {
    for (std::size_t first = 0; first < n; first += kBasePart)
      LODE_CHECK(
          writer.append(key_of(kind, static_cast<std::uint32_t>(first / kBasePart)),
                        as_block(encode(first, std::min<std::size_t>(kBasePart, n - first)))));
    return {};
  };
  LODE_CHECK(append(Kind::base_vertices, head.base_positions.size(),
                    [&](auto first, auto n) { return encode_vertices(head, first, n); }));
  LODE_CHECK(append(Kind::base_tetrahedra, head.base.size(),
                    [&](auto first, auto n) { return encode_tetrahedra(head, first, n); }));
  return append(Kind::roots, head.roots.size(), [&](auto first, auto n) {
    StreamWriter out;
    add_numbers(std::span(head.roots).subspan(first, n), out);
    return std::move(out).take();
  });
}

/// After all else, as only surfaces with normals ask for them.
Result<void> append_gradients(const PageShape& shape, std::span<const std::uint32_t> gradients,
                              store::Writer& writer) {
  const std::uint32_t n_pages = shape.n_pages() + n_pages_of(shape.n_base_vertices);
  for (std::uint32_t page = 0; page < n_pages; ++page) {
    const VertexRange range = vertices_of(shape, page);
    StreamWriter out;
    out.add_planes(gradients.subspan(range.first, range.n));
    LODE_CHECK(writer.append(key_of(Kind::gradients, page), as_block(std::move(out).take())));
  }
  return {};
}

}  // namespace

Result<std::uint64_t> save(const Hierarchy& hierarchy, std::uint64_t n_cells,
                           std::span<const std::uint32_t> gradients, const std::string& path,
                           Threads threads, Progress& progress) {
  constexpr std::size_t kPagesAtOnce = 256;
  const HierarchyHead head = head_of(hierarchy, n_cells);
  LODE_TRY(auto writer, store::Writer::create(path, kModelName, encode_head(head)));
  LODE_CHECK(append_base(head, writer));
  const std::size_t n_pages = head.shape.n_pages();
  const std::size_t n_fields = head.shape.n_fields;
  std::vector<store::EncodedBlock> blocks(kPagesAtOnce * (1 + n_fields));
  for (std::size_t first = 0; first < n_pages; first += kPagesAtOnce) {
    const std::size_t n = std::min(kPagesAtOnce, n_pages - first);
    parallel_for(n, threads, 1, [&](std::size_t i, int) {
      const auto number = static_cast<std::uint32_t>(first + i);
      const PageContent content = content_of(hierarchy, head, number);
      blocks[i * (1 + n_fields)] = as_block(encode_links(content, number, head.shape));
      for (std::size_t f = 0; f < n_fields; ++f)
        blocks[i * (1 + n_fields) + 1 + f] = as_block(encode_field(content, f, head.shape));
    });
    for (std::size_t i = 0; i < n * (1 + n_fields); ++i) {
      const auto number = static_cast<std::uint32_t>(first + i / (1 + n_fields));
      const auto part = static_cast<std::uint32_t>(i % (1 + n_fields));
      const auto key =
          part == 0 ? key_of(Kind::links, number) : key_of(Kind::field, number, part - 1);
      LODE_CHECK(writer.append(key, blocks[i]));
    }
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("writing", static_cast<double>(first + n) / static_cast<double>(n_pages));
  }
  LODE_CHECK(append_gradients(head.shape, gradients, writer));
  return writer.finish(progress);
}

}  // namespace lode::tetra_mt
