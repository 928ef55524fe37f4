#include <algorithm>
#include <span>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/page_gradients.h"
#include "lode/models/tetra_mt/page_primers.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt {
namespace {

std::vector<std::byte> encode_vertices(const HierarchyHead& head, std::size_t first,
                                       std::size_t n) {
  std::vector<double> coordinates;
  for (const Vec3d& p : std::span(head.base_positions).subspan(first, n))
    coordinates.insert(coordinates.end(), p.v.begin(), p.v.end());
  StreamWriter out;
  write_numbers(coordinates, 3, head.shape.has_narrow_positions, out);
  return std::move(out).take();
}

Result<void> append_base(const HierarchyHead& head, store::Writer& writer) {
  const auto append = [&](Kind kind, std::size_t n, const auto& encode) {
    return append_parts(
        n, kBasePart, [&](std::uint32_t part) { return key_of(kind, part); }, encode, writer);
  };
  LODE_CHECK(append(Kind::base_vertices, head.base_positions.size(),
                    [&](auto first, auto n) { return encode_vertices(head, first, n); }));
  const BaseTetrahedra base{head.base, head.base_makers, head.base_regions};
  LODE_CHECK(writer.append(key_of(Kind::base_tetrahedra, 0),
                           as_block(encode_base(base, base_limits_of(head)))));
  LODE_CHECK(writer.append(
      key_of(Kind::front, 0),
      as_block(encode_front(*head.front, front_base_of(head), BoxCodes(head.lower, head.upper)))));
  return append(Kind::roots, head.roots.size(), [&](auto first, auto n) {
    StreamWriter out;
    write_differences_of(std::span(head.roots).subspan(first, n), out);
    return std::move(out).take();
  });
}

template <typename Models>
using PrimerBytes = Primers<Models, std::vector<std::byte>>;

/// `encode(page, models)`: the bytes of a page.
template <typename Models, typename Encode>
Result<PrimerBytes<Models>> primers_by(std::uint32_t n_pages, const Encode& encode) {
  return PrimerBytes<Models>::of(
      n_pages, [&](std::uint32_t page, Models& models) -> Result<std::vector<std::byte>> {
        return encode(page, models);
      });
}

/// Pages 0 to n_pages - 1; calls of `encode` by many threads at once.
template <typename Models, typename Encode, typename Report>
Result<void> append_primed(std::uint32_t n_pages, Kind kind, std::uint32_t level,
                           const Encode& encode, Threads threads, const Report& report,
                           store::Writer& writer) {
  constexpr std::uint32_t kPagesAtOnce = 256;
  LODE_TRY(const auto primers, primers_by<Models>(n_pages, encode));
  std::vector<store::EncodedBlock> blocks(kPagesAtOnce);
  for (std::uint32_t first = 0; first < n_pages; first += kPagesAtOnce) {
    const std::uint32_t n = std::min(kPagesAtOnce, n_pages - first);
    parallel_for(n, threads, 1, [&](std::size_t i, int) {
      const auto page = static_cast<std::uint32_t>(first + i);
      blocks[i] =
          as_block(primers.page(page, [&](Models& models) { return encode(page, models); }));
    });
    for (std::uint32_t i = 0; i < n; ++i)
      LODE_CHECK(writer.append(key_of(kind, first + i, level), blocks[i]));
    LODE_CHECK(report(first + n));
  }
  return {};
}

Result<void> append_links(const Hierarchy& hierarchy, const PageShape& shape, Threads threads,
                          Progress& progress, store::Writer& writer) {
  LODE_CHECK(append_primed<LinkModels>(
      shape.n_pages(), Kind::links, 0,
      [&](std::uint32_t page, LinkModels& models) {
        return encode_links(content_of(hierarchy, page), page, shape, models);
      },
      threads,
      [&](std::uint32_t n_done) -> Result<void> {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("writing", static_cast<double>(n_done) / shape.n_pages());
        return {};
      },
      writer));
  return {};
}

Result<void> append_mesh_vertices(const Hierarchy& hierarchy, const PageShape& shape,
                                  store::Writer& writer) {
  for (std::uint32_t page = 0; page < shape.n_vertex_pages(); ++page) {
    const VertexRange range = vertices_of(shape, page);
    StreamWriter out;
    write_differences_of(std::span(hierarchy.mesh_vertices).subspan(range.first, range.n), out);
    LODE_CHECK(writer.append(key_of(Kind::mesh_vertices, page), as_block(std::move(out).take())));
  }
  return {};
}

}  // namespace

Result<void> append_field(const NumberedField& field, std::span<const std::uint32_t> gradients,
                          const TreeOf& tree_of, HierarchyHead& head, Threads threads,
                          store::Writer& writer) {
  const auto number = static_cast<std::uint32_t>(head.fields.size());
  if (number >= kMaxFields)
    return fail("{}: expected up to {} fields, got more", field.name, kMaxFields);
  const PageShape& shape = head.shape;
  head.fields.push_back(head_of(field, head.base_makers));
  const bool is_narrow = head.fields.back().has_narrow_values;
  const auto no_report = [](std::uint32_t /*n_done*/) { return Result<void>(); };
  const FieldBase base = base_of(field, shape);
  const std::size_t n_base = base.values.size();
  for (std::size_t first = 0; first == 0 || first < n_base; first += kBasePart) {
    StreamWriter out;
    if (first == 0) write_numbers(base.scale.knots(), 1, false, out);
    write_numbers(
        std::span(base.values).subspan(first, std::min<std::size_t>(kBasePart, n_base - first)), 1,
        is_narrow, out);
    const auto part = static_cast<std::uint32_t>(first / kBasePart);
    LODE_CHECK(
        writer.append(key_of(Kind::base_field, part, number), as_block(std::move(out).take())));
  }
  const WorldCodes codes(head.lower, head.upper);
  const auto front = front_facts_of(field, base.scale, codes, head.front->nodes);
  LODE_CHECK(
      writer.append(key_of(Kind::front_facts, 0, number),
                    as_block(encode_front_facts(front, head.front->nodes, front_base_of(head),
                                                base.values, base.scale))));
  LODE_CHECK(append_primed<FieldModels>(
      shape.n_pages(), Kind::field, number,
      [&](std::uint32_t page, FieldModels& models) {
        const auto content = content_of(field, base.scale, shape, page);
        return encode_field(content, base.scale, tree_of(page), is_narrow, models);
      },
      threads, no_report, writer));
  if (field.has_world_errors) {
    for (std::uint32_t page = 0; page < shape.n_pages(); ++page) {
      StreamWriter out;
      out.add(world_page_of(field, codes, shape, page));
      LODE_CHECK(
          writer.append(key_of(Kind::world_errors, page, number), as_block(std::move(out).take())));
    }
  }
  if (gradients.empty()) return {};  // of a lean file
  return append_primed<GradientModels>(
      shape.n_vertex_pages(), Kind::gradients, number,
      [&](std::uint32_t page, GradientModels& models) {
        const VertexRange range = vertices_of(shape, page);
        return encode_gradients(gradients.subspan(range.first, range.n), models);
      },
      threads, no_report, writer);
}

Result<std::uint64_t> save(const Hierarchy& hierarchy, std::uint64_t n_cells,
                           const GradientsOf& gradients, const std::string& path, Threads threads,
                           Progress& progress) {
  HierarchyHead head = head_of(hierarchy, n_cells);
  head.front = std::make_shared<const FrontNodes>(front_of(hierarchy, head));
  head.fields.clear();
  LODE_TRY(auto writer, store::Writer::create(path, kModelName, {}));
  LODE_CHECK(append_base(head, writer));
  LODE_CHECK(append_links(hierarchy, head.shape, threads, progress, writer));
  if (gradients) LODE_CHECK(append_mesh_vertices(hierarchy, head.shape, writer));
  const auto tree_of = [&](std::uint32_t page) {
    return PageTree::of(content_of(hierarchy, page), page);
  };
  for (std::size_t f = 0; f < hierarchy.fields.size(); ++f)
    LODE_CHECK(append_field(field_of(hierarchy, f),
                            gradients ? gradients(f) : std::vector<std::uint32_t>(), tree_of, head,
                            threads, writer));
  writer.set_metadata(encode_head(head));
  return writer.finish(progress);
}

}  // namespace lode::tetra_mt
