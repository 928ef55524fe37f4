#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/midpoint/field_blocks.h"
#include "lode/models/tetra_mt/midpoint/file_layout.h"
#include "lode/models/tetra_mt/midpoint/forest_blocks.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// Labels, codes and facts, then how far leaves are off their codes.
std::vector<std::byte> encode_roots(const ForestHead& head, std::size_t first, std::size_t n) {
  StreamWriter out;
  write_differences_of(std::span(head.roots).subspan(first, n), out);
  std::vector<std::uint32_t> column;
  for (std::size_t axis = 0; axis < 4; ++axis) {
    column.clear();
    for (const Code& code : std::span(head.root_codes).subspan(first, n))
      column.push_back(static_cast<std::uint32_t>(code[axis]));
    write_differences_of(column, out);
  }
  write_differences_of(std::span(head.root_facts).subspan(first, n), out);
  std::vector<std::uint8_t> is_off;
  std::vector<double> offsets;
  for (const std::uint32_t root : std::span(head.roots).subspan(first, n)) {
    const LeafOffset* const offset = head.base_exact.find(root);
    is_off.push_back(offset != nullptr ? 1 : 0);
    if (offset != nullptr) offsets.insert(offsets.end(), offset->axes.begin(), offset->axes.end());
  }
  out.add(is_off);
  write_numbers(offsets, 4, false, out);
  return std::move(out).take();
}

/// Corners are places of roots, and how many there are for the vertex outside.
std::vector<std::byte> encode_tetrahedra(const ForestHead& head) {
  BaseTetrahedra base{head.base, std::vector<std::uint32_t>(head.base.size(), kNone),
                      head.base_regions};
  for (Tetrahedron& t : base.corners)
    for (std::uint32_t& v : t)
      v = static_cast<std::uint32_t>(v == head.outside() ? head.roots.size()
                                                         : head.place_of_root(v));
  return encode_base(base, base_limits_of(head, static_cast<std::uint32_t>(head.roots.size())));
}

Result<void> append_base(const Hierarchy& head, store::Writer& writer) {
  const auto append = [&](Kind kind, std::size_t n, std::size_t size, const auto& encode) {
    return append_parts(
        n, size, [&](std::uint32_t part) { return key_of(kind, part); }, encode, writer);
  };
  LODE_CHECK(append(Kind::table, head.page_counts.size(), kTablePart, [&](auto first, auto n) {
    return encode_table(std::span(head.page_counts).subspan(first, n));
  }));
  LODE_CHECK(append(Kind::roots, head.roots.size(), kBasePart,
                    [&](auto first, auto n) { return encode_roots(head, first, n); }));
  LODE_CHECK(writer.append(key_of(Kind::base_tetrahedra, 0), as_block(encode_tetrahedra(head))));
  return append(Kind::coincident_leaves, head.coincident_leaves.size(), kBasePart,
                [&](auto first, auto n) {
                  StreamWriter out;
                  write_differences_of(std::span(head.coincident_leaves).subspan(first, n), out);
                  return std::move(out).take();
                });
}

/// Encodes pages side by side, and appends them in their order. `encode(page)`: its bytes.
template <typename Encode>
Result<void> append_pages(std::uint32_t n_pages, Kind kind, std::size_t field, Threads threads,
                          const Encode& encode, store::Writer& writer, Progress& progress) {
  constexpr std::uint32_t kPagesAtOnce = 256;
  std::vector<store::EncodedBlock> blocks(kPagesAtOnce);
  for (std::uint32_t first = 0; first < n_pages; first += kPagesAtOnce) {
    const std::uint32_t n = std::min(kPagesAtOnce, n_pages - first);
    parallel_for(n, threads, 1, [&](std::size_t i, int) {
      blocks[i] = as_block(encode(first + static_cast<std::uint32_t>(i)));
    });
    for (std::uint32_t i = 0; i < n; ++i)
      LODE_CHECK(writer.append(key_of(kind, first + i, field), blocks[i]));
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("writing", static_cast<double>(first + n) / static_cast<double>(n_pages));
  }
  return {};
}

}  // namespace

Result<void> append_field(const ForestHead& head, std::size_t field, const FurtherField& records,
                          const NodesOf& nodes_of, Threads threads, store::Writer& writer,
                          Progress& progress) {
  LODE_CHECK(append_parts(
      head.roots.size(), kBasePart,
      [&](std::uint32_t part) { return key_of(Kind::field_roots, part, field); },
      [&](auto first, auto n) { return encode_field_roots(records.roots, head, first, n); },
      writer));
  return append_pages(
      head.pages.n_pages(), Kind::field_page, field, threads,
      [&](std::uint32_t page) {
        const ForestPage nodes = nodes_of(page);
        return encode_field_page(field_page_of(head, nodes, records, page), head,
                                 head.fields[field], page, nodes);
      },
      writer, progress);
}

Result<void> append_world_errors(const ForestHead& head, std::size_t field, const WorldPage& codes,
                                 store::Writer& writer) {
  if (codes.empty()) return {};
  for (std::uint32_t page = 0; page < head.pages.n_pages(); ++page) {
    WorldPage column;
    for (std::uint32_t place = 0; place < head.pages.n_nodes_of(page); ++place)
      column.push_back(codes[head.pages.node_at(page, place)]);
    StreamWriter out;
    out.add(column);
    LODE_CHECK(
        writer.append(key_of(Kind::world_errors, page, field), as_block(std::move(out).take())));
  }
  return {};
}

Result<std::uint64_t> save(const Hierarchy& hierarchy, const std::string& path, Threads threads,
                           Progress& progress) {
  LODE_TRY(auto writer, store::Writer::create(path, kModelName, {}));
  LODE_CHECK(append_base(hierarchy, writer));
  LODE_CHECK(append_pages(
      hierarchy.pages.n_pages(), Kind::page, 0, threads,
      [&](std::uint32_t page) { return encode_page(content_of(hierarchy, page), hierarchy, page); },
      writer, progress));
  const auto nodes_of = [&](std::uint32_t page) {
    return ForestPage(content_of(hierarchy, page), hierarchy.pages, page, hierarchy.n_vertices);
  };
  for (std::size_t f = 0; f < hierarchy.fields.size(); ++f) {
    if (f > 0)
      LODE_CHECK(append_field(hierarchy, f, hierarchy.further[f - 1], nodes_of, threads, writer,
                              progress));
    LODE_CHECK(append_world_errors(hierarchy, f, hierarchy.world_codes[f], writer));
  }
  writer.set_metadata(encode_head(hierarchy));
  return writer.finish(progress);
}

}  // namespace lode::tetra_mt::midpoint
