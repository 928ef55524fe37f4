#include "lode/models/tetra_mt/midpoint/file_layout.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/store/bytes.h"

namespace lode::tetra_mt::midpoint {
namespace {

Result<void> read_field(store::ByteReader& in, const std::string& path, ForestHead& head) {
  LODE_TRY(head.field, in.read_string());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  head.type = static_cast<ScalarType>(type);
  if (!is_valid(head.type))
    return fail("{}: metadata: expected a sample type 1..10, got {}", path, type);
  LODE_TRY(head.base_error, in.read<double>());
  if (!(head.base_error >= 0))
    return fail("{}: metadata: expected an error >= 0, got {}", path, head.base_error);
  LODE_TRY(head.low, in.read<double>());
  LODE_TRY(head.high, in.read<double>());
  if (!(head.low <= head.high) || !std::isfinite(head.low) || !std::isfinite(head.high - head.low))
    return fail("{}: metadata: expected a finite range of {}, got {} to {}", path, head.field,
                head.low, head.high);
  return {};
}

Result<Scales> read_scales(store::ByteReader& in, const std::string& path) {
  std::array<Scale, 4> axes;
  for (Scale& axis : axes) {
    LODE_TRY(const auto exponent, in.read<std::int32_t>());
    LODE_TRY(const auto first, in.read<std::int64_t>());
    if (!Scale::is_valid(exponent, first))
      return fail("{}: metadata: expected steps of finite numbers, got 2^{} from {} on", path,
                  exponent, first);
    axis = Scale(exponent, first);
  }
  return Scales(axes);
}

Result<NodeCodes> read_codes(store::ByteReader& in, const std::string& path,
                             const ForestHead& head) {
  LODE_TRY(const double error, in.read<double>());
  LODE_TRY(const double radius, in.read<double>());
  if (!(error >= 0) || !(radius >= 0) || !std::isfinite(error) || !std::isfinite(radius))
    return fail("{}: metadata: expected a largest error and radius >= 0, got {} and {}", path,
                error, radius);
  NodeCodes::Knots knots{};
  for (double& knot : knots) {
    LODE_TRY(knot, in.read<double>());
  }
  if (!std::ranges::is_sorted(knots) || knots.front() != head.low || knots.back() != head.high ||
      std::ranges::any_of(knots, [](double knot) { return !std::isfinite(knot); }))
    return fail("{}: metadata: expected knots that ascend from {} to {}, got {} to {}", path,
                head.low, head.high, knots.front(), knots.back());
  return NodeCodes(knots, error, radius);
}

Result<void> check_counts(const ForestHead& head, const ForestCounts& counts,
                          const std::string& path) {
  if (head.n_base_leaves > head.n_vertices || counts.n_roots < head.n_base_leaves ||
      (counts.n_pages > 0) != (counts.n_roots > head.n_base_leaves))
    return fail(
        "{}: metadata: expected no more than {} vertices, and nodes with roots, got {}, {} "
        "roots and {} pages",
        path, head.n_vertices, head.n_base_leaves, counts.n_roots, counts.n_pages);
  if (head.n_vertices >= kNone || counts.n_tetrahedra >= kNone ||
      head.n_base_cells > counts.n_tetrahedra || head.n_base_cells > head.n_cells)
    return fail("{}: metadata: expected fewer cells of the base than tetrahedra, got {} and {}",
                path, head.n_base_cells, counts.n_tetrahedra);
  return {};
}

}  // namespace

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
  write_labels(labels_of(head), out);
  out.write_string(head.field);
  out.write(static_cast<std::uint8_t>(head.type));
  for (const double x : {head.base_error, head.low, head.high}) out.write(x);
  for (const Scale& axis : head.scales.axes()) {
    out.write(static_cast<std::int32_t>(axis.exponent()));
    out.write(axis.first());
  }
  out.write(head.codes.largest_error());
  out.write(head.codes.largest_radius());
  for (const double knot : head.codes.knots()) out.write(knot);
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
  LODE_TRY(HeadLabels labels, read_labels(in, path));
  take_labels(std::move(labels), head);
  LODE_CHECK(read_field(in, path, head));
  LODE_TRY(head.scales, read_scales(in, path));
  LODE_TRY(head.codes, read_codes(in, path, head));
  LODE_CHECK(in.expect_end());
  LODE_CHECK(check_counts(head, counts, path));
  return head;
}

}  // namespace lode::tetra_mt::midpoint
