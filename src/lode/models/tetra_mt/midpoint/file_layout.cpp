#include "lode/models/tetra_mt/midpoint/file_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/build_record.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/store/bytes.h"

namespace lode::tetra_mt::midpoint {
namespace {

Result<Scale> read_scale(store::ByteReader& in, const std::string& path) {
  LODE_TRY(const auto exponent, in.read<std::int32_t>());
  LODE_TRY(const auto first, in.read<std::int64_t>());
  if (!Scale::is_valid(exponent, first))
    return fail("{}: metadata: expected steps of finite numbers, got 2^{} from {} on", path,
                exponent, first);
  return Scale(exponent, first);
}

Result<std::optional<double>> read_time(store::ByteReader& in, const std::string& path,
                                        const std::string& field) {
  LODE_TRY(const auto has_time, in.read<std::uint8_t>());
  LODE_TRY(const double time, in.read<double>());
  if (has_time > 1 || !std::isfinite(time) || (has_time == 0 && time != 0))
    return fail("{}: metadata: expected 1 and a finite time of {}, or 0 and 0, got {} and {}", path,
                field, has_time, time);
  return has_time == 1 ? std::optional(time) : std::nullopt;
}

Result<double> read_largest(store::ByteReader& in, const std::string& path, const char* what) {
  LODE_TRY(const double number, in.read<double>());
  if (number >= 0 && std::isfinite(number)) return number;
  return fail("{}: metadata: expected a largest {} >= 0, got {}", path, what, number);
}

Result<NodeCodes> read_codes(store::ByteReader& in, const std::string& path,
                             const ForestField& field) {
  LODE_TRY(const double error, read_largest(in, path, "error"));
  NodeCodes::Knots knots{};
  for (double& knot : knots) {
    LODE_TRY(knot, in.read<double>());
  }
  if (!std::ranges::is_sorted(knots) || knots.front() != field.low || knots.back() != field.high ||
      std::ranges::any_of(knots, [](double knot) { return !std::isfinite(knot); }))
    return fail("{}: metadata: expected knots that ascend from {} to {}, got {} to {}", path,
                field.low, field.high, knots.front(), knots.back());
  return NodeCodes(knots, error);
}

Result<ForestField> read_field(store::ByteReader& in, const std::string& path) {
  ForestField field;
  LODE_TRY(field.name, in.read_string());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  field.type = static_cast<ScalarType>(type);
  if (!is_valid(field.type))
    return fail("{}: metadata: expected a sample type 1..10, got {}", path, type);
  LODE_TRY(field.time, read_time(in, path, field.name));
  LODE_TRY(field.base_error, in.read<double>());
  if (!(field.base_error >= 0))
    return fail("{}: metadata: expected an error >= 0, got {}", path, field.base_error);
  LODE_TRY(field.low, in.read<double>());
  LODE_TRY(field.high, in.read<double>());
  if (!(field.low <= field.high) || !std::isfinite(field.low) ||
      !std::isfinite(field.high - field.low))
    return fail("{}: metadata: expected a finite range of {}, got {} to {}", path, field.name,
                field.low, field.high);
  LODE_TRY(field.scale, read_scale(in, path));
  LODE_TRY(field.codes, read_codes(in, path, field));
  LODE_TRY(field.base_world_error, read_world_error(in, path, field.name));
  return field;
}

Result<void> read_fields(store::ByteReader& in, const std::string& path, ForestHead& head) {
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  if (n == 0 || n > kMaxFields)
    return fail("{}: metadata: expected 1 to {} fields, got {}", path, kMaxFields, n);
  for (std::uint32_t f = 0; f < n; ++f) {
    LODE_TRY(auto field, read_field(in, path));
    head.fields.push_back(std::move(field));
  }
  return {};
}

void write_scale(const Scale& scale, store::ByteWriter& out) {
  out.write(static_cast<std::int32_t>(scale.exponent()));
  out.write(scale.first());
}

void write_field(const ForestField& field, store::ByteWriter& out) {
  out.write_string(field.name);
  out.write(static_cast<std::uint8_t>(field.type));
  out.write(static_cast<std::uint8_t>(field.time ? 1 : 0));
  for (const double x : {field.time.value_or(0), field.base_error, field.low, field.high})
    out.write(x);
  write_scale(field.scale, out);
  out.write(field.codes.largest_error());
  for (const double knot : field.codes.knots()) out.write(knot);
  write_world_error(field.base_world_error, out);
}

Result<void> check_counts(const ForestHead& head, const ForestCounts& counts,
                          const std::string& path) {
  if (head.n_base_leaves > head.n_vertices || counts.n_roots < head.n_base_leaves ||
      (counts.n_pages > 0) != (counts.n_roots > head.n_base_leaves))
    return fail(
        "{}: metadata: expected no more than {} vertices, and nodes with roots, got {}, {} "
        "roots and {} pages",
        path, head.n_vertices, head.n_base_leaves, counts.n_roots, counts.n_pages);
  if (head.n_coincident_leaves > head.n_vertices)
    return fail("{}: metadata: expected up to {} vertices that lie where others do, got {}", path,
                head.n_vertices, head.n_coincident_leaves);
  if (head.n_vertices >= kNone || counts.n_tetrahedra >= kNone ||
      head.n_base_cells > counts.n_tetrahedra || head.n_base_cells > head.n_cells)
    return fail("{}: metadata: expected fewer cells of the base than tetrahedra, got {} and {}",
                path, head.n_base_cells, counts.n_tetrahedra);
  return {};
}

}  // namespace

BaseLimits base_limits_of(const ForestHead& head, std::uint32_t n_roots) {
  BaseLimits limits{.n_vertices = n_roots, .outside = n_roots};
  if (head.has_regions())
    limits.n_labels = {static_cast<std::uint32_t>(std::max<std::size_t>(1, head.region_ids.size())),
                       static_cast<std::uint32_t>(head.patches.size()) + 1};
  return limits;
}

std::vector<std::byte> encode_head(const ForestHead& head) {
  store::ByteWriter out;
  out.write(kLayout);
  out.write(head.n_vertices);
  out.write(head.pages.n_pages());
  out.write(head.n_base_leaves);
  out.write(static_cast<std::uint32_t>(head.roots.size()));
  out.write(head.n_cells);
  out.write(head.n_base_cells);
  out.write(static_cast<std::uint64_t>(head.base.size()));
  for (const Vec3d* corner : {&head.box.lower, &head.box.upper})
    for (const double x : corner->v) out.write(x);
  out.write(head.boundary_deviation);
  out.write(head.n_coincident_leaves);
  write_labels(labels_of(head), out);
  write_record(head.record, out);
  for (const Scale& axis : head.scales.axes()) write_scale(axis, out);
  out.write(head.radii.largest());
  out.write(static_cast<std::uint32_t>(head.fields.size()));
  for (const ForestField& field : head.fields) write_field(field, out);
  return std::move(out).take();
}

Result<ForestHead> decode_head(std::span<const std::byte> bytes, const std::string& path,
                               ForestCounts& counts) {
  store::ByteReader in(bytes, path + ": metadata");
  ForestHead head;
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: expected layout {} of midpoints, got {}: build the file again", path, kLayout,
                layout);
  LODE_TRY(head.n_vertices, in.read<std::uint32_t>());
  LODE_TRY(counts.n_pages, in.read<std::uint32_t>());
  LODE_TRY(head.n_base_leaves, in.read<std::uint32_t>());
  LODE_TRY(counts.n_roots, in.read<std::uint32_t>());
  LODE_TRY(head.n_cells, in.read<std::uint64_t>());
  LODE_TRY(head.n_base_cells, in.read<std::uint64_t>());
  LODE_TRY(counts.n_tetrahedra, in.read<std::uint64_t>());
  LODE_CHECK(read_box(in, path, head.box.lower, head.box.upper));
  LODE_TRY(head.boundary_deviation, read_deviation(in, path));
  LODE_TRY(head.n_coincident_leaves, in.read<std::uint32_t>());
  LODE_TRY(HeadLabels labels, read_labels(in, path));
  take_labels(std::move(labels), head);
  LODE_TRY(head.record, read_record(in, path));
  std::array<Scale, 3> axes;
  for (Scale& axis : axes) {
    LODE_TRY(axis, read_scale(in, path));
  }
  head.scales = Scales(axes);
  LODE_TRY(const double radius, read_largest(in, path, "radius"));
  head.radii = RadiusCodes(radius);
  LODE_CHECK(read_fields(in, path, head));
  LODE_CHECK(in.expect_end());
  LODE_CHECK(check_counts(head, counts, path));
  return head;
}

}  // namespace lode::tetra_mt::midpoint
