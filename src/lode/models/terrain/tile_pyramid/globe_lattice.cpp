#include "lode/models/terrain/tile_pyramid/globe_lattice.h"

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "lode/core/ellipsoid.h"
#include "lode/models/terrain/tile_pyramid/build.h"

namespace lode::tile_pyramid {

int n_globe_cells(int level) {
  constexpr double kPart = 3.0 / 8;
  const double radius = kWgs84Ellipsoid.semi_major;
  const double width = std::ldexp(std::numbers::pi * radius, -level);
  const double most = kPart * std::ldexp(kLevelZeroError, -level);
  // One less than powers of 2: the middle of a side, where sides of finer tiles end between two
  // nodes, is the middle of a cell.
  int n = 1;
  while (width * width / n / n / (4 * radius) > most) n = 2 * n + 1;
  return n;
}

std::int32_t most_gap(int level) {
  const int n = n_globe_cells(level);
  return (kLastNode + n - 1) / n;
}

std::vector<LatticePoint> missing_globe_nodes(const TileMesh& mesh, int level) {
  const int n = n_globe_cells(level);
  const auto place = [&](int i) { return (2 * i * kLastNode + n) / (2 * n); };
  const auto nearest = [&](std::int32_t node) {
    return (2 * node * n + kLastNode) / (2 * kLastNode);
  };
  const std::int32_t near = most_gap(level) / 4;
  const auto row_size = static_cast<std::size_t>(n) + 1;
  std::vector<bool> is_near(row_size * row_size);
  for (const TileVertex& vertex : mesh.vertices) {
    const int i = nearest(vertex.node.x);
    const int j = nearest(vertex.node.y);
    if (std::abs(vertex.node.x - place(i)) <= near && std::abs(vertex.node.y - place(j)) <= near)
      is_near[static_cast<std::size_t>(j) * row_size + static_cast<std::size_t>(i)] = true;
  }
  std::vector<LatticePoint> nodes;
  for (int j = 1; j < n; ++j)
    for (int i = 1; i < n; ++i)
      if (!is_near[static_cast<std::size_t>(j) * row_size + static_cast<std::size_t>(i)])
        nodes.push_back({place(i), place(j)});
  return nodes;
}

}  // namespace lode::tile_pyramid
