#include "lode/mappers/creases.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "lode/core/disjoint_sets.h"

namespace lode {
namespace {

/// A triangle's side from one of its corners to the next, by its vertices, the smaller first.
struct EdgeSide {
  std::uint32_t low;
  std::uint32_t high;
  std::uint32_t corner;  ///< Three times the triangle, and its corner that the side starts at.
};

std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

std::vector<EdgeSide> sides_of(std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t corner = 0; corner < 3 * triangles.size(); ++corner) {
    const auto& triangle = triangles[corner / 3];
    const std::uint32_t a = triangle[corner % 3];
    const std::uint32_t b = triangle[next_corner(corner) % 3];
    sides.push_back({std::min(a, b), std::max(a, b), corner});
  }
  std::ranges::sort(sides, {}, [](const EdgeSide& side) {
    return std::pair{std::uint64_t{side.low} << 32 | side.high, side.corner};
  });
  return sides;
}

/// Of unit length, or zero where a triangle has none.
std::vector<Vec3d> normals_of(std::span<const Vec3f> positions,
                              std::span<const std::array<std::uint32_t, 3>> triangles) {
  const auto at = [&](std::uint32_t vertex) {
    const Vec3f& p = positions[vertex];
    return Vec3d{{p[0], p[1], p[2]}};
  };
  std::vector<Vec3d> normals;
  normals.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles)
    normals.push_back(normalized(cross(at(b) - at(a), at(c) - at(a))));
  return normals;
}

}  // namespace

std::vector<std::uint32_t> split_at_creases(std::span<const Vec3f> positions, double angle,
                                            std::span<std::array<std::uint32_t, 3>> triangles) {
  const double least_cosine = std::cos(angle);
  const std::vector<Vec3d> normals = normals_of(positions, triangles);
  // Triangles without a normal are part of what is beside them.
  const auto is_smooth = [&](std::uint32_t one, std::uint32_t other) {
    const double product = dot(normals[one], normals[other]);
    return product >= least_cosine || dot(normals[one], normals[one]) == 0 ||
           dot(normals[other], normals[other]) == 0;
  };
  // Corners that are one vertex are in one set.
  DisjointSets<> sets(3 * triangles.size());
  const std::vector<EdgeSide> sides = sides_of(triangles);
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    const auto is_same = [&](const EdgeSide& side) {
      return side.low == sides[begin].low && side.high == sides[begin].high;
    };
    while (end < sides.size() && is_same(sides[end])) ++end;
    if (end - begin != 2) continue;
    const std::uint32_t a = sides[begin].corner;
    const std::uint32_t b = sides[begin + 1].corner;
    const bool is_opposite = triangles[a / 3][a % 3] != triangles[b / 3][b % 3];
    if (!is_opposite || !is_smooth(a / 3, b / 3)) continue;
    sets.join(a, next_corner(b));
    sets.join(next_corner(a), b);
  }
  std::vector<std::uint32_t> copies;
  std::vector<bool> is_taken(positions.size());
  std::vector<std::uint32_t> numbers(3 * triangles.size());
  for (std::uint32_t corner = 0; corner < numbers.size(); ++corner) {
    std::uint32_t& vertex = triangles[corner / 3][corner % 3];
    const std::uint32_t first = sets.find(corner);
    if (first == corner) {
      numbers[corner] = vertex;
      if (is_taken[vertex]) {
        numbers[corner] = static_cast<std::uint32_t>(positions.size() + copies.size());
        copies.push_back(vertex);
      }
      is_taken[vertex] = true;
    }
    vertex = numbers[first];
  }
  return copies;
}

}  // namespace lode
