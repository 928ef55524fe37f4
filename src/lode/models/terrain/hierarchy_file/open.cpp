#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <tuple>
#include <utility>

#include "lode/core/expects.h"
#include "lode/models/terrain/hierarchy_file/file_layout.h"
#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"
#include "lode/models/terrain/hierarchy_file/levels_check.h"
#include "lode/store/bytes.h"
#include "lode/store/reader.h"

namespace lode::hierarchy_file {
namespace {

using triangle_hierarchy::Hierarchy;
using triangle_hierarchy::kNone;
using triangle_hierarchy::LatticePoint;

/// Half-edges are numbered in 32 bits, four a triangle.
constexpr std::uint32_t kMostTriangles = (std::uint32_t{1} << 30) - 1;
constexpr std::uint32_t kMostBits = 8;
constexpr int kCoordinateBits = 30;

/// The last node of the fine lattice.
LatticePoint last_node(const HeightFrame& frame, int bits) {
  return {(frame.n_columns - 1) << bits, (frame.n_rows - 1) << bits};
}

Result<void> check_rising(const std::string& path, const char* what,
                          const std::vector<std::uint32_t>& until, std::uint32_t least,
                          std::uint32_t most) {
  for (std::size_t i = 0; i < until.size(); ++i)
    if (until[i] > most || until[i] < (i > 0 ? until[i - 1] : least))
      return fail("{}: metadata: expected {} that get more, up to {}, got {} until level {}", path,
                  what, most, until[i], i);
  return {};
}

Result<void> read_lattice(store::ByteReader& in, const std::string& path, Head& head) {
  LODE_TRY(const auto bits, in.read<std::uint32_t>());
  const HeightFrame& frame = head.source.frame;
  const std::int64_t last = std::int64_t{std::max(frame.n_columns, frame.n_rows)} - 1;
  if (bits > kMostBits || (last << bits) >> kCoordinateBits != 0)
    return fail(
        "{}: metadata: expected columns and rows at most 2^{} nodes apart, whose numbers "
        "have {} bits, got 2^{}",
        path, kMostBits, kCoordinateBits, bits);
  head.bits = static_cast<int>(bits);
  const auto& g = frame.to_world;
  if (std::ldexp(g[1] * g[5] - g[2] * g[4], -2 * head.bits) == 0)
    return fail("{}: metadata: expected nodes that span a plane", path);
  LODE_TRY(head.reach, in.read<std::int32_t>());
  if (head.reach < 0 || head.reach > (last << bits))
    return fail("{}: metadata: expected a reach from 0 to {}, got {}", path, last << bits,
                head.reach);
  return {};
}

Result<Head> read_head(const store::Reader& reader) {
  const std::string& path = reader.path();
  store::ByteReader in(reader.metadata(), path + ": metadata");
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: metadata: expected layout {} of the model {}, got {}: build the file again",
                path, kLayout, reader.model(), layout);
  Head head;
  LODE_TRY(const auto is_of_points, in.read<std::uint8_t>());
  if (is_of_points > 1)
    return fail("{}: metadata: expected a {} of a raster or of points, got kind {}", path,
                reader.model(), is_of_points);
  head.source.is_of_points = is_of_points != 0;
  LODE_CHECK(terrain_file::read(in, path, head.source));
  LODE_TRY(head.tolerances, terrain_file::read_levels(in, path));
  if (head.tolerances.empty()) return fail("{}: metadata: expected levels, got none", path);
  LODE_CHECK(read_lattice(in, path, head));
  LODE_TRY(head.n_lines, in.read<std::uint32_t>());
  LODE_TRY(head.n_crowded, in.read<std::uint32_t>());
  LODE_TRY(head.vertices_until, in.read_all<std::uint32_t>(head.tolerances.size()));
  LODE_TRY(head.triangles_until, in.read_all<std::uint32_t>(head.tolerances.size()));
  LODE_TRY(head.refinements_until, in.read_all<std::uint32_t>(head.tolerances.size()));
  LODE_CHECK(in.expect_end());
  LODE_CHECK(check_rising(path, "vertices", head.vertices_until, 1, kNone - 1));
  LODE_CHECK(check_rising(path, "triangles", head.triangles_until, 1, kMostTriangles));
  LODE_CHECK(check_rising(path, "refinements", head.refinements_until, 0,
                          head.triangles_until.back() - 1));
  const std::uint32_t most = head.source.is_of_points ? head.refinements_until.back() : 0;
  if (head.n_crowded > most)
    return fail("{}: metadata: expected up to {} refined triangles with points beside them, got {}",
                path, most, head.n_crowded);
  return head;
}

/// The first of all numbers of a column.
template <typename T>
Result<std::vector<T>> read_first(const store::Reader& reader, Column column, std::uint64_t n,
                                  std::uint64_t n_all) {
  using terrain_file::kPart;
  const std::uint64_t n_read = std::min(n_all, (n + kPart - 1) / kPart * kPart);
  LODE_TRY(std::vector<T> numbers, terrain_file::read_column<T>(reader, key_of(column), n_read));
  numbers.resize(static_cast<std::size_t>(n));
  return numbers;
}

Result<void> read_vertices(const store::Reader& reader, const Head& head, Hierarchy& h) {
  const std::uint32_t n = h.vertices_until.back();
  const std::uint32_t n_all = head.vertices_until.back();
  LODE_TRY(const auto x, read_first<std::int32_t>(reader, Column::x, n, n_all));
  LODE_TRY(const auto y, read_first<std::int32_t>(reader, Column::y, n, n_all));
  LODE_TRY(h.heights, read_first<double>(reader, Column::height, n, n_all));
  const LatticePoint last = last_node(h.frame, h.bits);
  const HeightRange& range = head.source.range;
  h.vertices.reserve(n);
  for (std::uint32_t v = 0; v < n; ++v) {
    if (x[v] < 0 || x[v] > last.x || y[v] < 0 || y[v] > last.y)
      return fail("{}: vertex {}: expected a node from 0, 0 to {}, {}, got {}, {}", reader.path(),
                  v, last.x, last.y, x[v], y[v]);
    if (!(h.heights[v] >= range.lower && h.heights[v] <= range.upper))
      return fail("{}: vertex {}: expected a height from {} to {}, got {}", reader.path(), v,
                  range.lower, range.upper, h.heights[v]);
    h.vertices.push_back({x[v], y[v]});
  }
  h.in_rows.resize(n);
  std::iota(h.in_rows.begin(), h.in_rows.end(), 0U);
  const auto place = [&](std::uint32_t v) { return std::tuple(y[v], x[v]); };
  std::ranges::sort(h.in_rows, {}, place);
  for (std::size_t i = 1; i < h.in_rows.size(); ++i)
    if (place(h.in_rows[i - 1]) == place(h.in_rows[i]))
      return fail("{}: expected vertices at places of their own, got {} and {} at one",
                  reader.path(), h.in_rows[i - 1], h.in_rows[i]);
  return {};
}

Result<void> read_triangles(const store::Reader& reader, const Head& head, Hierarchy& h) {
  const std::uint64_t n = h.triangles_until.back();
  const std::uint64_t n_all = head.triangles_until.back();
  LODE_TRY(const auto corners, read_first<std::uint32_t>(reader, Column::corner, 3 * n, 3 * n_all));
  LODE_TRY(const auto errors, read_first<float>(reader, Column::error, n, n_all));
  constexpr std::uint32_t kOutside = delaunay::kNoHalfEdge;
  h.triangles.reserve(n);
  std::size_t level = 0;
  for (std::uint32_t t = 0; t < n; ++t) {
    while (t >= h.triangles_until[level]) ++level;
    const std::array<std::uint32_t, 3> corner{corners[3 * std::size_t{t}],
                                              corners[3 * std::size_t{t} + 1],
                                              corners[3 * std::size_t{t} + 2]};
    for (const std::uint32_t v : corner)
      if (v >= h.vertices_until[level])
        return fail("{}: triangle {}: expected vertices below {}, got {}", reader.path(), t,
                    h.vertices_until[level], v);
    if (delaunay::doubled_area(h.vertices[corner[0]], h.vertices[corner[1]],
                               h.vertices[corner[2]]) <= 0)
      return fail("{}: triangle {}: expected corners that turn left, got {}, {}, {}", reader.path(),
                  t, corner[0], corner[1], corner[2]);
    if (!(errors[t] >= 0) || !std::isfinite(errors[t]))
      return fail("{}: triangle {}: expected a finite error >= 0, got {}", reader.path(), t,
                  errors[t]);
    h.triangles.push_back(
        {.corner = corner, .twin = {kOutside, kOutside, kOutside}, .error = errors[t]});
  }
  return {};
}

/// Refinements follow one another without gaps, and none is of two levels.
Result<void> read_refinements(const store::Reader& reader, const Head& head, Hierarchy& h) {
  const std::uint32_t n = head.refinements_until[h.tolerances.size() - 1];
  const std::uint32_t n_all = head.refinements_until.back();
  LODE_TRY(const auto refined, read_first<std::uint32_t>(reader, Column::refined, n, n_all));
  LODE_TRY(const auto counts, read_first<std::uint32_t>(reader, Column::n_triangles, n, n_all));
  std::uint64_t first = h.triangles_until[0];
  std::size_t level = 1;
  h.refinements.reserve(n);
  for (std::uint32_t r = 0; r < n; ++r) {
    while (level < h.triangles_until.size() && first >= h.triangles_until[level]) ++level;
    if (level == h.triangles_until.size() || counts[r] < 2 ||
        first + counts[r] > h.triangles_until[level])
      return fail("{}: refinement {}: expected from 2 triangles to those of a level, got {}",
                  reader.path(), r, counts[r]);
    if (r >= head.refinements_until[level] || r < head.refinements_until[level - 1])
      return fail("{}: refinement {}: expected one of level {}, {} to {}, as its triangles are",
                  reader.path(), r, level, head.refinements_until[level - 1],
                  head.refinements_until[level]);
    if (refined[r] >= h.triangles_until[level - 1])
      return fail("{}: refinement {}: expected a triangle of a level before, below {}, got {}",
                  reader.path(), r, h.triangles_until[level - 1], refined[r]);
    std::uint32_t& refinement = h.triangles[refined[r]].refinement;
    if (refinement != kNone)
      return fail("{}: refinement {}: expected a triangle that no other refines, got {}",
                  reader.path(), r, refined[r]);
    refinement = r;
    h.refinements.push_back({refined[r], static_cast<std::uint32_t>(first)});
    first += counts[r];
  }
  if (first != h.triangles.size())
    return fail("{}: expected {} triangles in all refinements, got {}", reader.path(),
                h.triangles.size() - h.triangles_until[0], first - h.triangles_until[0]);
  return {};
}

/// That meshes have them is for verification to say.
Result<void> read_lines(const store::Reader& reader, std::uint64_t n, Hierarchy& h) {
  LODE_TRY(const auto ends, read_first<std::uint32_t>(reader, Column::line, 2 * n, 2 * n));
  h.lines.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::array<std::uint32_t, 2> line{ends[2 * i], ends[2 * i + 1]};
    if (std::max(line[0], line[1]) >= h.vertices_until[0] || line[0] == line[1])
      return fail("{}: line {}: expected two vertices below {}, got {} and {}", reader.path(), i,
                  h.vertices_until[0], line[0], line[1]);
    h.lines.push_back(line);
  }
  return {};
}

/// That others have no points beside them is for verification to say.
Result<void> read_crowded(const store::Reader& reader, std::uint64_t n, std::uint32_t n_triangles,
                          Hierarchy& h) {
  LODE_TRY(h.crowded, read_first<std::uint32_t>(reader, Column::crowded, n, n));
  for (std::size_t i = 0; i < h.crowded.size(); ++i)
    if (h.crowded[i] >= n_triangles || (i > 0 && h.crowded[i] <= h.crowded[i - 1]))
      return fail(
          "{}: expected triangles with points beside them that ascend, below {}, got {} as number "
          "{}",
          reader.path(), n_triangles, h.crowded[i], i);
  return {};
}

}  // namespace

HierarchyFile::HierarchyFile(store::Reader reader, Head head)
    : reader_(std::move(reader)), head_(std::move(head)) {}

Result<HierarchyFile> HierarchyFile::open(const std::string& path) {
  LODE_TRY(store::Reader reader, store::Reader::open(path));
  LODE_TRY(const std::size_t kind, terrain_file::find_model(reader, kModelNames));
  LODE_TRY(Head head, read_head(reader));
  head.kind = static_cast<Kind>(kind);
  return HierarchyFile(std::move(reader), std::move(head));
}

Result<HierarchyModel> HierarchyFile::read(int n_levels, Progress& progress) const {
  LODE_EXPECTS(n_levels > 0 && n_levels <= head_.n_levels());
  HierarchyModel model{.source = head_.source, .kind = head_.kind, .hierarchy = {}};
  Hierarchy& h = model.hierarchy;
  h.frame = head_.source.frame;
  h.is_of_points = head_.source.is_of_points;
  h.bits = head_.bits;
  h.reach = head_.reach;
  h.tolerances.assign(head_.tolerances.begin(), head_.tolerances.begin() + n_levels);
  h.vertices_until.assign(head_.vertices_until.begin(), head_.vertices_until.begin() + n_levels);
  h.triangles_until.assign(head_.triangles_until.begin(), head_.triangles_until.begin() + n_levels);
  LODE_CHECK(read_vertices(reader_, head_, h));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(read_triangles(reader_, head_, h));
  LODE_CHECK(read_refinements(reader_, head_, h));
  LODE_CHECK(read_lines(reader_, head_.n_lines, h));
  LODE_CHECK(read_crowded(reader_, head_.n_crowded, head_.triangles_until.back(), h));
  const HeightRange& range = head_.source.range;
  const double size = std::max(std::abs(range.lower), std::abs(range.upper));
  auto linked = link_levels(h, size, progress);
  if (!linked && progress.is_cancelled()) return cancelled_error();
  if (!linked) return fail("{}: {}", reader_.path(), linked.error().message);
  if (n_levels == head_.n_levels())
    for (const std::uint32_t t : h.crowded)
      if (h.triangles[t].refinement == kNone)
        return fail("{}: expected triangles with points beside them to be refined, got {}",
                    reader_.path(), t);
  return model;
}

Result<HierarchyModel> open(const std::string& path, Progress& progress) {
  LODE_TRY(const HierarchyFile file, HierarchyFile::open(path));
  return file.read(file.head().n_levels(), progress);
}

}  // namespace lode::hierarchy_file
