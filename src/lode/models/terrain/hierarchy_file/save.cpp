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

std::vector<std::byte> encode_head(const HierarchyModel& model) {
  const Hierarchy& hierarchy = model.hierarchy;
  store::ByteWriter out;
  out.write(kLayout);
  terrain_file::write(out, model.source);
  terrain_file::write_levels(out, hierarchy.tolerances);
  out.write(static_cast<std::uint32_t>(hierarchy.bits));
  out.write(hierarchy.reach);
  out.write(static_cast<std::uint32_t>(hierarchy.refinements.size()));
  out.write(static_cast<std::uint32_t>(hierarchy.lines.size()));
  out.write_all(std::span<const std::uint32_t>(hierarchy.vertices_until));
  out.write_all(std::span<const std::uint32_t>(hierarchy.triangles_until));
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

}  // namespace

std::string_view model_name(const HierarchyModel& model) {
  return kModelNames[static_cast<std::size_t>(model.kind)];
}

Result<std::uint64_t> save(const HierarchyModel& model, const std::string& path,
                           Progress& progress) {
  LODE_TRY(auto writer, store::Writer::create(path, model_name(model), encode_head(model)));
  LODE_CHECK(append_vertices(model.hierarchy, writer));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(append_triangles(model.hierarchy, writer));
  LODE_CHECK(append_refinements(model.hierarchy, writer));
  LODE_CHECK(append_lines(model.hierarchy, writer));
  return writer.finish(progress);
}

}  // namespace lode::hierarchy_file
