#include "lode/models/tetra_mt/file_layout.h"

#include <cmath>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/build_record.h"
#include "lode/store/bytes.h"

namespace lode::tetra_mt {
namespace {

Result<bool> read_flag(store::ByteReader& in, const std::string& path) {
  LODE_TRY(const auto flag, in.read<std::uint8_t>());
  if (flag > 1) return fail("{}: metadata: expected 0 or 1, got {}", path, flag);
  return flag == 1;
}

Result<HierarchyHead::Field> read_field(store::ByteReader& in, const std::string& path) {
  HierarchyHead::Field field;
  LODE_TRY(field.name, in.read_string());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  field.type = static_cast<ScalarType>(type);
  if (!is_valid(field.type))
    return fail("{}: metadata: expected a sample type 1..10, got {}", path, type);
  LODE_TRY(field.has_narrow_values, read_flag(in, path));
  LODE_TRY(field.has_errors_everywhere, read_flag(in, path));
  LODE_TRY(const bool has_time, read_flag(in, path));
  LODE_TRY(const double time, in.read<double>());
  if (!std::isfinite(time) || (!has_time && time != 0))
    return fail("{}: metadata: expected a finite time of {}, or 0 for none, got {}", path,
                field.name, time);
  if (has_time) field.time = time;
  LODE_TRY(field.base_error, in.read<double>());
  if (!(field.base_error >= 0))
    return fail("{}: metadata: expected an error >= 0, got {}", path, field.base_error);
  LODE_TRY(field.low, in.read<double>());
  LODE_TRY(field.high, in.read<double>());
  if (!(field.low <= field.high) || !std::isfinite(field.low) ||
      !std::isfinite(field.high - field.low))
    return fail("{}: metadata: expected a finite range of {}, got {} to {}", path, field.name,
                field.low, field.high);
  LODE_TRY(field.base_world_error, read_world_error(in, path, field.name));
  return field;
}

Result<void> check_counts(const HierarchyHead& head, const BaseCounts& counts,
                          const std::string& path) {
  const PageShape& shape = head.shape;
  const std::uint64_t n_vertices = std::uint64_t{shape.n_base_vertices} + shape.n_nodes;
  if (n_vertices >= kNone || (shape.n_base_vertices == 0 && shape.n_nodes > 0))
    return fail("{}: metadata: expected fewer than {} vertices, some of the base, got {} and {}",
                path, kNone, shape.n_base_vertices, shape.n_nodes);
  if (counts.n_roots > shape.n_nodes || counts.n_tetrahedra >= kNone ||
      head.n_base_cells > counts.n_tetrahedra || head.n_base_cells > head.n_cells)
    return fail(
        "{}: metadata: expected as many roots as nodes at most, and fewer cells of the base than "
        "tetrahedra, got {}, {} and {}, {}",
        path, counts.n_roots, shape.n_nodes, head.n_base_cells, counts.n_tetrahedra);
  return {};
}

}  // namespace

BaseLimits base_limits_of(const HierarchyHead& head) {
  BaseLimits limits{.n_vertices = head.shape.n_base_vertices,
                    .outside = head.outside(),
                    .n_nodes = head.shape.n_nodes};
  if (head.shape.n_labels > 1)
    limits.n_labels = {head.shape.n_regions, static_cast<std::uint32_t>(head.patches.size()) + 1};
  return limits;
}

std::vector<std::byte> encode_head(const HierarchyHead& head) {
  store::ByteWriter out;
  out.write(kLayout);
  out.write(head.shape.n_base_vertices);
  out.write(head.shape.n_nodes);
  out.write(static_cast<std::uint8_t>(head.shape.has_narrow_positions ? 1 : 0));
  out.write(head.n_cells);
  out.write(head.n_base_cells);
  out.write(static_cast<std::uint64_t>(head.base.size()));
  out.write(static_cast<std::uint64_t>(head.roots.size()));
  for (const Vec3d* corner : {&head.lower, &head.upper})
    for (const double x : corner->v) out.write(x);
  out.write(head.boundary_deviation);
  write_labels(labels_of(head), out);
  write_record(head.record, out);
  out.write(static_cast<std::uint32_t>(head.fields.size()));
  for (const HierarchyHead::Field& field : head.fields) {
    out.write_string(field.name);
    out.write(static_cast<std::uint8_t>(field.type));
    out.write(static_cast<std::uint8_t>(field.has_narrow_values ? 1 : 0));
    out.write(static_cast<std::uint8_t>(field.has_errors_everywhere ? 1 : 0));
    out.write(static_cast<std::uint8_t>(field.time ? 1 : 0));
    for (const double x : {field.time.value_or(0), field.base_error, field.low, field.high})
      out.write(x);
    write_world_error(field.base_world_error, out);
  }
  return std::move(out).take();
}

Result<HierarchyHead> decode_head(std::span<const std::byte> bytes, const std::string& path,
                                  BaseCounts& counts) {
  store::ByteReader in(bytes, path + ": metadata");
  HierarchyHead head;
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: expected layout {} of tetrahedra, got {}: build the file again", path, kLayout,
                layout);
  LODE_TRY(head.shape.n_base_vertices, in.read<std::uint32_t>());
  LODE_TRY(head.shape.n_nodes, in.read<std::uint32_t>());
  LODE_TRY(head.shape.has_narrow_positions, read_flag(in, path));
  LODE_TRY(head.n_cells, in.read<std::uint64_t>());
  LODE_TRY(head.n_base_cells, in.read<std::uint64_t>());
  LODE_TRY(counts.n_tetrahedra, in.read<std::uint64_t>());
  LODE_TRY(counts.n_roots, in.read<std::uint64_t>());
  LODE_CHECK(read_box(in, path, head.lower, head.upper));
  LODE_TRY(head.boundary_deviation, read_deviation(in, path));
  LODE_TRY(HeadLabels labels, read_labels(in, path));
  take_labels(std::move(labels), head);
  LODE_TRY(head.record, read_record(in, path));
  head.shape.n_labels = n_labels_of(head.region_ids, head.patches);
  head.shape.n_regions = n_regions_of(head.region_ids);
  LODE_TRY(const auto n_fields, in.read<std::uint32_t>());
  if (n_fields < 1 || n_fields > kMaxFields)
    return fail("{}: metadata: expected 1 to {} fields, got {}", path, kMaxFields, n_fields);
  for (std::uint32_t f = 0; f < n_fields; ++f) {
    LODE_TRY(auto field, read_field(in, path));
    head.fields.push_back(std::move(field));
  }
  LODE_CHECK(in.expect_end());
  LODE_CHECK(check_counts(head, counts, path));
  return head;
}

}  // namespace lode::tetra_mt
