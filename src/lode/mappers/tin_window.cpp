#include "lode/mappers/tin_window.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace lode {
namespace {

using WorldCorners = std::array<Vec<double, 2>, 3>;

double turn_of(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Whether an axis or an edge of the triangle parts the two; else they meet.
bool meets(const WorldCorners& corners, const WorldWindow& window) {
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [least, most] = std::minmax({corners[0][i], corners[1][i], corners[2][i]});
    if (most < window.lower[i] || least > window.upper[i]) return false;
  }
  const WorldCorners& c = corners;
  const double side = turn_of(c[0], c[1], c[2]) < 0 ? -1 : 1;
  const std::array<Vec<double, 2>, 4> of_window{window.lower,
                                                {{window.upper[0], window.lower[1]}},
                                                window.upper,
                                                {{window.lower[0], window.upper[1]}}};
  for (std::size_t i = 0; i < 3; ++i)
    if (std::ranges::all_of(of_window, [&](const Vec<double, 2>& p) {
          return side * turn_of(c[i], c[(i + 1) % 3], p) < 0;
        }))
      return false;
  return true;
}

/// Those that triangles have, in their order.
void keep_used_vertices(delaunay::Tin& tin) {
  std::vector<std::uint32_t> numbers(tin.vertices.size(), 0);
  for (const auto& triangle : tin.triangles)
    for (const std::uint32_t v : triangle) numbers[v] = 1;
  std::uint32_t n = 0;
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == 0) continue;
    tin.vertices[n] = tin.vertices[v];
    if (!tin.heights.empty()) tin.heights[n] = tin.heights[v];
    numbers[v] = n++;
  }
  tin.vertices.resize(n);
  if (!tin.heights.empty()) tin.heights.resize(n);
  for (auto& triangle : tin.triangles)
    for (std::uint32_t& v : triangle) v = numbers[v];
}

}  // namespace

void keep_in_window(delaunay::Tin& tin, const HeightFrame& frame, const WorldWindow& window) {
  const auto world = [&](std::uint32_t v) {
    return frame.world(tin.vertices[v].x, tin.vertices[v].y);
  };
  std::size_t n = 0;
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    const auto [a, b, c] = tin.triangles[t];
    if (!meets({world(a), world(b), world(c)}, window)) continue;
    tin.triangles[n] = tin.triangles[t];
    if (!tin.errors.empty()) tin.errors[n] = tin.errors[t];
    ++n;
  }
  tin.triangles.resize(n);
  if (!tin.errors.empty()) tin.errors.resize(n);
  tin.twins.clear();
  keep_used_vertices(tin);
}

}  // namespace lode
