#include "lode/models/terrain/delaunay_pyramid/linked_levels.h"

#include <algorithm>

#include "lode/models/terrain/insertions/file_head.h"

namespace lode::delaunay_pyramid {

using delaunay::LatticeCorners;
using delaunay::LatticePoint;
using terrain_file::kPart;

std::string LinkedLevels::place_of(const KeptTriangle& t) const {
  return fmt::format("{}: level {}: triangle {}", file_.path(), t.level, t.number);
}

LinkedLevels::VertexPlace LinkedLevels::place_of(std::uint32_t v) const {
  const auto& until = head().vertices_until;
  const auto level = static_cast<std::size_t>(std::ranges::upper_bound(until, v) - until.begin());
  const std::uint32_t first = head().first_vertex(level);
  return {level, v - first, until[level] - first};
}

Result<LatticePoint> LinkedLevels::vertex(std::uint32_t v) {
  const auto [level, number, n] = place_of(v);
  LODE_TRY(const auto x, coordinates_[0].at(file_, key_of(Column::x, level), n, number));
  LODE_TRY(const auto y, coordinates_[1].at(file_, key_of(Column::y, level), n, number));
  const HeightFrame& frame = head().source.frame;
  if (x < 0 || y < 0 || x >= frame.n_columns || y >= frame.n_rows)
    return fail("{}: level {}: expected vertices in {} x {}, got column {}, row {}", file_.path(),
                level, frame.n_columns, frame.n_rows, x, y);
  return LatticePoint{x, y};
}

Result<double> LinkedLevels::height(std::uint32_t v) {
  const auto [level, number, n] = place_of(v);
  const auto key = key_of(Column::height, level);
  double height = 0;
  switch (head().height_type) {
    case terrain_file::StoredHeight::int16: {
      LODE_TRY(height, int16_heights_.at(file_, key, n, number));
      break;
    }
    case terrain_file::StoredHeight::float32: {
      LODE_TRY(const float z, float_heights_.at(file_, key, n, number));
      height = static_cast<double>(z);
      break;
    }
    case terrain_file::StoredHeight::float64: {
      LODE_TRY(height, double_heights_.at(file_, key, n, number));
      break;
    }
  }
  const HeightRange& range = head().source.range;
  if (!(height >= range.lower && height <= range.upper))
    return fail("{}: level {}: expected heights from {} to {}, got {}", file_.path(), level,
                range.lower, range.upper, height);
  return height;
}

Result<LinkedLevels::Triple> LinkedLevels::corners(const KeptTriangle& t) {
  const std::uint64_t n = 3 * std::uint64_t{head().n_kept[t.level]};
  const std::uint32_t n_vertices = head().vertices_until[t.level];
  Triple corner{};
  for (std::size_t i = 0; i < 3; ++i) {
    LODE_TRY(corner[i], corners_.at(file_, key_of(Column::corners, t.level), n,
                                    3 * std::uint64_t{t.number} + i));
    if (corner[i] >= n_vertices)
      return fail("{}: expected one of {} vertices, got {}", place_of(t), n_vertices, corner[i]);
  }
  return corner;
}

Result<LatticeCorners> LinkedLevels::places(const KeptTriangle& t) {
  LODE_TRY(const Triple corner, corners(t));
  LatticeCorners places;
  for (std::size_t i = 0; i < 3; ++i) {
    LODE_TRY(places[i], vertex(corner[i]));
  }
  if (delaunay::doubled_area(places[0], places[1], places[2]) <= 0)
    return fail("{}: expected corners that turn left, got {}, {}, {}", place_of(t), corner[0],
                corner[1], corner[2]);
  return places;
}

Result<float> LinkedLevels::error(const KeptTriangle& t) {
  LODE_TRY(const auto half,
           errors_.at(file_, key_of(Column::error, t.level), head().n_kept[t.level], t.number));
  const float error = insertions::to_error(half);
  if (error < 0)
    return fail("{}: expected a finite error >= 0, got the upper half {:#x}", place_of(t), half);
  return error;
}

Result<std::uint32_t> LinkedLevels::end_of(const KeptTriangle& t) {
  if (!head().is_of_lists()) return t.level + 1;
  LODE_TRY(const std::uint16_t death,
           deaths_.at(file_, key_of(Column::death, t.level), head().n_kept[t.level], t.number));
  if (death <= t.level || death > head().n_levels())
    return fail("{}: expected an end with a level from {} to {}, got {}", place_of(t), t.level + 1,
                head().n_levels(), death);
  return std::uint32_t{death};
}

Result<std::pair<std::uint64_t, std::uint64_t>> LinkedLevels::link_range(const KeptTriangle& t) {
  const std::uint64_t part = t.number / kPart;
  const std::uint64_t n = head().n_kept[t.level];
  auto& ends = link_ends_[{t.level, part}];
  LODE_TRY(const std::uint64_t first,
           first_links_.at(file_, key_of(Column::first_links, t.level), n_parts(n), part));
  if (ends.empty()) {
    std::vector<std::uint64_t> sums;
    std::uint64_t sum = first;
    for (std::uint64_t i = part * kPart; i < std::min<std::uint64_t>(n, (part + 1) * kPart); ++i) {
      LODE_TRY(const auto count, n_links_.at(file_, key_of(Column::n_links, t.level), n, i));
      sums.push_back(sum += count);
    }
    if (first > head().n_links[t.level] || sum > head().n_links[t.level])
      return fail("{}: expected up to {} links, got {}", place_of(t), head().n_links[t.level], sum);
    ends = std::move(sums);
  }
  const std::uint64_t at = t.number % kPart;
  return std::pair(at > 0 ? ends[at - 1] : first, ends[at]);
}

Result<std::vector<KeptTriangle>> LinkedLevels::linked(const KeptTriangle& t) {
  LODE_TRY(const std::uint32_t to, end_of(t));
  LODE_EXPECTS(to < head().n_levels());
  LODE_TRY(const auto range, link_range(t));
  std::vector<KeptTriangle> all;
  for (std::uint64_t i = range.first; i < range.second; ++i) {
    LODE_TRY(const auto link,
             links_.at(file_, key_of(Column::links, t.level), head().n_links[t.level], i));
    if (link >= head().n_kept[to] || (!all.empty() && link <= all.back().number))
      return fail("{}: expected links that ascend, below {}, got {}", place_of(t),
                  head().n_kept[to], link);
    all.push_back({to, link});
  }
  return all;
}

}  // namespace lode::delaunay_pyramid
