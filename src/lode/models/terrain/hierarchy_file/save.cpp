#include <utility>
#include <vector>

#include "lode/models/terrain/hierarchy_file/file_layout.h"
#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"
#include "lode/store/bytes.h"
#include "lode/store/writer.h"

namespace lode::hierarchy_file {
namespace {

using terrain_file::append_column;
using triangle_hierarchy::Hierarchy;

std::vector<std::byte> encode(const Head& head) {
  store::ByteWriter out;
  out.write(kLayout);
  out.write(static_cast<std::uint8_t>(head.source.is_of_points));
  terrain_file::write(out, head.source);
  terrain_file::write_levels(out, head.tolerances);
  out.write(static_cast<std::uint32_t>(head.bits));
  out.write(head.reach);
  out.write(head.n_lines);
  out.write(head.n_crowded);
  out.write_all(std::span<const std::uint32_t>(head.vertices_until));
  out.write_all(std::span<const std::uint32_t>(head.triangles_until));
  out.write_all(std::span<const std::uint32_t>(head.refinements_until));
  return std::move(out).take();
}

Result<void> append_vertices(const Hierarchy& h, store::Writer& writer) {
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::x), h.vertices.size(), [&](std::uint64_t i) { return h.vertices[i].x; },
      writer));
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::y), h.vertices.size(), [&](std::uint64_t i) { return h.vertices[i].y; },
      writer));
  return append_column<double>(
      key_of(Column::height), h.heights.size(), [&](std::uint64_t i) { return h.heights[i]; },
      writer);
}

Result<void> append_triangles(const Hierarchy& h, store::Writer& writer) {
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::corner), 3 * std::uint64_t{h.triangles.size()},
      [&](std::uint64_t i) { return h.triangles[i / 3].corner[i % 3]; }, writer));
  return append_column<float>(
      key_of(Column::error), h.triangles.size(),
      [&](std::uint64_t i) { return h.triangles[i].error; }, writer);
}

Result<void> append_refinements(const Hierarchy& h, store::Writer& writer) {
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::refined), h.refinements.size(),
      [&](std::uint64_t i) { return h.refinements[i].triangle; }, writer));
  return append_column<std::uint32_t>(
      key_of(Column::n_triangles), h.refinements.size(),
      [&](std::uint64_t i) {
        const auto [first, end] = h.triangles_of(static_cast<std::uint32_t>(i));
        return end - first;
      },
      writer);
}

Result<void> append_lines(const Hierarchy& h, store::Writer& writer) {
  return append_column<std::uint32_t>(
      key_of(Column::line), 2 * std::uint64_t{h.lines.size()},
      [&](std::uint64_t i) { return h.lines[i / 2][i % 2]; }, writer);
}

Result<void> append_crowded(const Hierarchy& h, store::Writer& writer) {
  return append_column<std::uint32_t>(
      key_of(Column::crowded), h.crowded.size(), [&](std::uint64_t i) { return h.crowded[i]; },
      writer);
}

}  // namespace

Head head_of(const HierarchyModel& model) {
  const Hierarchy& h = model.hierarchy;
  Head head{.source = model.source,
            .kind = model.kind,
            .tolerances = h.tolerances,
            .bits = h.bits,
            .reach = h.reach,
            .n_lines = static_cast<std::uint32_t>(h.lines.size()),
            .n_crowded = static_cast<std::uint32_t>(h.crowded.size()),
            .vertices_until = h.vertices_until,
            .triangles_until = h.triangles_until,
            .refinements_until = {}};
  for (int level = 0; level < h.n_levels(); ++level)
    head.refinements_until.push_back(static_cast<std::uint32_t>(
        head.triangles_until[static_cast<std::size_t>(level)] - h.n_triangles_in(level)));
  return head;
}

std::uint64_t Head::n_bytes() const {
  using Triangle = Hierarchy::Triangle;
  using Refinement = Hierarchy::Refinement;
  constexpr std::uint64_t kOfVertex =
      sizeof(triangle_hierarchy::LatticePoint) + sizeof(double) + sizeof(std::uint32_t);
  return vertices_until.back() * kOfVertex + triangles_until.back() * sizeof(Triangle) +
         refinements_until.back() * sizeof(Refinement) + n_lines * 2 * sizeof(std::uint32_t) +
         n_crowded * sizeof(std::uint32_t) +
         tolerances.size() * (sizeof(double) + 2 * sizeof(std::uint32_t));
}

Result<std::uint64_t> save(const HierarchyModel& model, const std::string& path,
                           Progress& progress) {
  LODE_TRY(auto writer,
           store::Writer::create(path, kModelNames[static_cast<std::size_t>(model.kind)],
                                 encode(head_of(model))));
  LODE_CHECK(append_vertices(model.hierarchy, writer));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(append_triangles(model.hierarchy, writer));
  LODE_CHECK(append_refinements(model.hierarchy, writer));
  LODE_CHECK(append_lines(model.hierarchy, writer));
  LODE_CHECK(append_crowded(model.hierarchy, writer));
  return writer.finish(progress);
}

}  // namespace lode::hierarchy_file
