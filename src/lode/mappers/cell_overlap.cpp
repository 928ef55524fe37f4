#include "lode/mappers/cell_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace lode {
namespace {

using OverlapPart = std::array<OverlapCorner, 4>;

/// Where the face across from one of the other's corners cuts an edge.
OverlapCorner cut_edge(const OverlapCorner& inside, const OverlapCorner& outside,
                       std::size_t face) {
  const double t = inside.weights[face] / (inside.weights[face] - outside.weights[face]);
  OverlapCorner made;
  for (std::size_t k = 0; k < 4; ++k)
    made.weights[k] = inside.weights[k] + (outside.weights[k] - inside.weights[k]) * t;
  made.weights[face] = 0;
  made.difference = inside.difference + (outside.difference - inside.difference) * t;
  return made;
}

/// Appends what of a part is on the inner side of a face, in up to three parts.
void cut_overlap(const OverlapPart& part, std::size_t face, std::vector<OverlapPart>& parts) {
  std::array<OverlapCorner, 4> in;
  std::array<OverlapCorner, 4> off;
  std::size_t n_in = 0;
  std::size_t n_off = 0;
  for (const OverlapCorner& corner : part) {
    if (corner.weights[face] >= 0)
      in[n_in++] = corner;
    else
      off[n_off++] = corner;
  }
  if (n_off == 0) parts.push_back(part);
  if (n_off == 0 || n_in == 0) return;
  const auto cut = [&](std::size_t i, std::size_t k) { return cut_edge(in[i], off[k], face); };
  if (n_in == 1) {
    parts.push_back({in[0], cut(0, 0), cut(0, 1), cut(0, 2)});
    return;
  }
  // A prism between two triangles.
  const bool is_wedge = n_in == 2;
  const std::array<OverlapCorner, 3> a =
      is_wedge ? std::array{in[0], cut(0, 0), cut(0, 1)} : std::array{in[0], in[1], in[2]};
  const std::array<OverlapCorner, 3> b = is_wedge ? std::array{in[1], cut(1, 0), cut(1, 1)}
                                                  : std::array{cut(0, 0), cut(1, 0), cut(2, 0)};
  parts.push_back({a[0], a[1], a[2], b[2]});
  parts.push_back({a[0], a[1], b[1], b[2]});
  parts.push_back({a[0], b[0], b[1], b[2]});
}

}  // namespace

std::optional<CellOverlap> find_overlap(const std::array<OverlapCorner, 4>& cell) {
  for (std::size_t face = 0; face < 4; ++face)
    if (std::ranges::all_of(cell, [&](const OverlapCorner& c) { return c.weights[face] < 0; }))
      return std::nullopt;
  std::vector<OverlapPart> parts{cell};
  std::vector<OverlapPart> next;
  for (std::size_t face = 0; face < 4; ++face) {
    next.clear();
    for (const OverlapPart& part : parts) cut_overlap(part, face, next);
    std::swap(parts, next);
  }
  if (parts.empty()) return std::nullopt;
  CellOverlap overlap;
  const double share = 1 / (4 * static_cast<double>(parts.size()));
  for (const OverlapPart& part : parts)
    for (const OverlapCorner& corner : part) {
      overlap.largest = std::max(overlap.largest, std::abs(corner.difference));
      for (std::size_t k = 0; k < 4; ++k) overlap.centre[k] += share * corner.weights[k];
    }
  return overlap;
}

}  // namespace lode
