#include "lode/models/terrain/delaunay_pyramid/pyramid_head.h"

#include <algorithm>
#include <string>

#include "lode/models/terrain/delaunay_pyramid/file_layout.h"
#include "lode/store/bytes.h"

namespace lode::delaunay_pyramid {
namespace {

/// Half-edges are numbered in 32 bits, four a triangle.
constexpr std::uint32_t kMostTriangles = (std::uint32_t{1} << 30) - 1;

Result<void> check_vertices(const std::string& path, const PyramidHead& head) {
  constexpr std::uint32_t kMost = 1U << 30;
  std::uint32_t least = 3;
  for (const std::uint32_t n : head.vertices_until) {
    if (n < least || n > kMost)
      return fail("{}: metadata: expected levels of from {} to {} vertices, got {}", path, least,
                  kMost, n);
    least = n;
  }
  return {};
}

Result<void> check_triangles(const std::string& path, const PyramidHead& head) {
  for (std::size_t level = 0; level < head.n_levels(); ++level) {
    const std::uint32_t n = head.n_in_mesh[level];
    const std::uint32_t n_kept = head.n_kept[level];
    const std::uint64_t n_before = level > 0 ? head.n_in_mesh[level - 1] : 0;
    const bool is_mesh =
        n >= 1 && n <= kMostTriangles && n <= 2 * std::uint64_t{head.vertices_until[level]};
    // Of lists a mesh has what it makes, and of the mesh before what is left.
    const bool are_kept =
        n_kept <= n && (head.is_of_lists() && level > 0 ? n <= n_before + n_kept : n_kept == n);
    if (!is_mesh || !are_kept)
      return fail(
          "{}: metadata: level {}: expected triangles of a mesh of {} vertices, got {}, of them {} "
          "kept with it",
          path, level, head.vertices_until[level], n, n_kept);
  }
  return {};
}

Result<void> check_links(const std::string& path, const PyramidHead& head) {
  // No file has more, and so many can be added up.
  constexpr std::uint64_t kMost = std::uint64_t{1} << 48;
  std::uint64_t n_all = 0;
  for (std::size_t level = 0; level < head.n_levels(); ++level) {
    const bool has_some = has_links(head.encoding) && level + 1 < head.n_levels();
    if (!has_some && head.n_links[level] != 0)
      return fail("{}: metadata: level {}: expected no links, got {}", path, level,
                  head.n_links[level]);
    const std::uint64_t n_pairs = std::uint64_t{head.n_kept[level]} *
                                  *std::max_element(head.n_in_mesh.begin(), head.n_in_mesh.end());
    const std::uint64_t most = std::min(n_pairs, kMost - n_all);
    if (head.n_links[level] > most)
      return fail("{}: metadata: level {}: expected up to {} links of {} triangles, got {}", path,
                  level, most, head.n_kept[level], head.n_links[level]);
    n_all += head.n_links[level];
  }
  return {};
}

Result<void> read_facts(store::ByteReader& in, const std::string& path, PyramidHead& head) {
  constexpr double kLargestAngle = 60 + 1e-6;
  for (std::size_t level = 0; level < head.n_levels(); ++level) {
    MeshFacts facts;
    LODE_TRY(facts.largest_error, in.read<double>());
    LODE_TRY(facts.smallest_angle, in.read<double>());
    LODE_TRY(facts.median_angle, in.read<double>());
    const bool is_error = facts.largest_error >= 0 &&
                          facts.largest_error <= static_cast<double>(head.most_stated(level));
    const bool are_angles = facts.smallest_angle >= 0 &&
                            facts.smallest_angle <= facts.median_angle &&
                            facts.median_angle <= kLargestAngle;
    if (!is_error || !are_angles)
      return fail(
          "{}: metadata: level {}: expected an error up to {} and smallest angles, got {}, {} and "
          "{}",
          path, level, head.most_stated(level), facts.largest_error, facts.smallest_angle,
          facts.median_angle);
    head.facts.push_back(facts);
  }
  return {};
}

Result<void> read_counts(store::ByteReader& in, const std::string& path, PyramidHead& head) {
  const std::size_t n = head.n_levels();
  LODE_TRY(head.vertices_until, in.read_all<std::uint32_t>(n));
  LODE_TRY(head.n_in_mesh, in.read_all<std::uint32_t>(n));
  LODE_TRY(head.n_kept, in.read_all<std::uint32_t>(n));
  LODE_TRY(head.n_links, in.read_all<std::uint64_t>(n));
  LODE_CHECK(read_facts(in, path, head));
  LODE_CHECK(in.expect_end());
  LODE_CHECK(check_vertices(path, head));
  LODE_CHECK(check_triangles(path, head));
  return check_links(path, head);
}

}  // namespace

Result<PyramidHead> read_head(const store::Reader& reader) {
  const std::string& path = reader.path();
  PyramidHead head;
  LODE_TRY(const std::size_t encoding, terrain_file::find_model(reader, kModelNames));
  head.encoding = static_cast<Encoding>(encoding);
  store::ByteReader in(reader.metadata(), path + ": metadata");
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: metadata: expected layout {} of the model {}, got {}: build the file again",
                path, kLayout, reader.model(), layout);
  LODE_TRY(const auto is_of_points, in.read<std::uint8_t>());
  if (is_of_points > 1)
    return fail("{}: metadata: expected a {} of a raster or of points, got kind {}", path,
                reader.model(), is_of_points);
  head.source.is_of_points = is_of_points != 0;
  LODE_CHECK(terrain_file::read(in, path, head.source));
  LODE_TRY(head.max_error, in.read<double>());
  LODE_TRY(head.tolerances, terrain_file::read_levels(in, path));
  if (head.tolerances.empty()) return fail("{}: metadata: expected levels, got none", path);
  if (!(head.max_error >= 0) || head.max_error > head.tolerances.back())
    return fail("{}: metadata: expected an error from 0 to that of the last level, {}, got {}",
                path, head.tolerances.back(), head.max_error);
  LODE_TRY(head.height_type, terrain_file::read_stored_height(in, path));
  LODE_TRY(head.n_lines, in.read<std::uint32_t>());
  LODE_CHECK(read_counts(in, path, head));
  const std::uint64_t most = head.source.is_of_points ? 3 * std::uint64_t{head.n_in_mesh[0]} : 0;
  if (head.n_lines > most)
    return fail("{}: metadata: expected up to {} lines, got {}", path, most, head.n_lines);
  return head;
}

}  // namespace lode::delaunay_pyramid
