#include "lode/delaunay/regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lode/core/expects.h"
#include "lode/core/uninitialized_array.h"

namespace lode::delaunay {
namespace {

/// Fewer would have much of a border.
constexpr std::size_t kLeastTriangles = 1024;
constexpr std::size_t kMostRegions = 64;

/// By triangle, the square that its middle lies in, of n by n with about as many in each row, and
/// in each of a row's.
std::vector<std::uint32_t> find_squares(const LatticeMesh& mesh, std::size_t n) {
  struct Middle {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::uint32_t triangle = 0;
  };
  std::vector<Middle> middles;
  middles.reserve(mesh.triangles().size());
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    Middle middle{0, 0, t};
    for (const std::uint32_t corner : mesh.triangles()[t].corner) {
      const LatticePoint p = mesh.nodes().unpack(corner);
      middle.x += p.x;
      middle.y += p.y;
    }
    middles.push_back(middle);
  }
  std::vector<std::uint32_t> square_of(middles.size());
  const auto part = [](std::size_t size, std::size_t i, std::size_t of) { return size * i / of; };
  std::ranges::sort(middles, {}, [](const Middle& m) { return std::pair(m.y, m.triangle); });
  for (std::size_t row = 0; row < n; ++row) {
    const std::size_t first = part(middles.size(), row, n);
    const std::size_t end = part(middles.size(), row + 1, n);
    const auto in_row = std::span(middles).subspan(first, end - first);
    std::ranges::sort(in_row, {}, [](const Middle& m) { return std::pair(m.x, m.triangle); });
    for (std::size_t column = 0; column < n; ++column)
      for (std::size_t i = part(in_row.size(), column, n); i < part(in_row.size(), column + 1, n);
           ++i)
        square_of[in_row[i].triangle] = static_cast<std::uint32_t>(row * n + column);
  }
  return square_of;
}

}  // namespace

std::vector<Region> cut_into_regions(const LatticeMesh& mesh) {
  const auto& triangles = mesh.triangles();
  const std::size_t wanted = std::min(triangles.size() / kLeastTriangles, kMostRegions);
  const auto n = static_cast<std::size_t>(std::sqrt(static_cast<double>(wanted)));
  if (n < 2) return {};
  const std::vector<std::uint32_t> region_of = find_squares(mesh, n);
  std::vector<Region> regions(n * n);
  std::vector<std::uint32_t> slot_of(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    LatticeTriangles& own = regions[region_of[t]].triangles;
    slot_of[t] = static_cast<std::uint32_t>(own.size());
    own.push_back(triangles[t]);
  }
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    Region& region = regions[region_of[t]];
    LatticeTriangle& triangle = region.triangles[slot_of[t]];
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t twin = triangle.twin[i];
      if (twin == kNoHalfEdge) continue;
      if (region_of[twin >> 2] == region_of[t]) {
        triangle.twin[i] = 4 * slot_of[twin >> 2] + (twin & 3);
        continue;
      }
      triangle.twin[i] = kNoHalfEdge;
      region.border[border_key(triangle.corner[i], triangle.corner[(i + 1) % 3])] =
          4 * slot_of[t] + i;
    }
  }
  return regions;
}

LatticeTriangles join_regions(std::vector<Region>& regions, Threads threads,
                              std::vector<std::uint32_t>& border) {
  std::vector<std::uint32_t> first(regions.size() + 1, 0);
  for (std::size_t r = 0; r < regions.size(); ++r)
    first[r + 1] = first[r] + static_cast<std::uint32_t>(regions[r].triangles.size());
  LatticeTriangles joined;
  joined.resize(first.back());
  parallel_for(regions.size(), threads, 1, [&](std::size_t r, int) {
    Region& region = regions[r];
    for (std::size_t t = 0; t < region.triangles.size(); ++t) {
      LatticeTriangle& made = joined[first[r] + t];
      made = region.triangles[t];
      for (std::uint32_t i = 0; i < 3; ++i) {
        if (made.twin[i] != kNoHalfEdge) {
          made.twin[i] += 4 * first[r];
        } else if (const auto found =
                       region.border.find(border_key(made.corner[i], made.corner[(i + 1) % 3]));
                   found != region.border.end()) {
          found->second = 4 * (first[r] + static_cast<std::uint32_t>(t)) + i;
        }
      }
    }
    LatticeTriangles().swap(region.triangles);
  });
  std::unordered_map<std::uint64_t, std::uint32_t> all;
  for (Region& region : regions) all.merge(region.border);
  border.clear();
  for (const auto& [key, half_edge] : all) {
    const auto from = static_cast<std::uint32_t>(key >> 32);
    const auto to = static_cast<std::uint32_t>(key);
    const auto other = all.find(border_key(to, from));
    LODE_EXPECTS(other != all.end());
    joined[half_edge >> 2].twin[half_edge & 3] = other->second;
    if (from < to) border.push_back(half_edge);
  }
  std::ranges::sort(border);
  return joined;
}

}  // namespace lode::delaunay
