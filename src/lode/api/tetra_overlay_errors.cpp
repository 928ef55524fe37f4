#include "lode/api/tetra_overlay_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "lode/mappers/cell_overlap.h"

namespace lode {

void TetraOverlayErrors::append(const TetraOverlayErrors& later) {
  n_cells += later.n_cells;
  n_above_stated += later.n_above_stated;
  largest = std::max(largest, later.largest);
  largest_stated = std::max(largest_stated, later.largest_stated);
  if (first.empty()) first = later.first;
}

TetraOverlay::TetraOverlay(const TetraVertices& vertices, const TetraCells& reference,
                           Threads threads)
    : vertices_(vertices),
      reference_(reference),
      locator_(vertices.positions, reference.corners, threads) {}

/// Of corners, above the faces across.
std::array<double, 4> TetraOverlay::heights_of(const tetra_mt::Tetrahedron& cell) const {
  std::array<double, 4> heights{};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto face = tetra_mt::others(cell, k);
    const Vec3d& origin = vertices_.positions[face[0]];
    const Vec3d normal =
        cross(vertices_.positions[face[1]] - origin, vertices_.positions[face[2]] - origin);
    heights[k] = std::abs(dot(normal, vertices_.positions[cell[k]] - origin)) / length(normal);
  }
  return heights;
}

double TetraOverlay::largest_in(const tetra_mt::Tetrahedron& cell) const {
  const std::array<tetra_mt::Tetrahedron, 1> one{cell};
  const CellLocator of_cell(vertices_.positions, one, {1});
  Box3d box{vertices_.positions[cell[0]], vertices_.positions[cell[0]]};
  std::array<double, 4> values{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3d& p = vertices_.positions[cell[k]];
    values[k] = vertices_.values[cell[k]];
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], p[i]);
      box.upper[i] = std::max(box.upper[i], p[i]);
    }
  }
  const double low = std::ranges::min(values);
  const double high = std::ranges::max(values);
  const double allowance = vertices_.boundary_allowance();
  const std::array<double, 4> heights = heights_of(cell);
  const auto meets = [&](const Box3d& other) {
    bool is = true;
    for (std::size_t i = 0; i < 3; ++i)
      is = is && other.lower[i] <= box.upper[i] && box.lower[i] <= other.upper[i];
    return is;
  };
  double largest = 0;
  locator_.visit_where(meets, [&](std::uint32_t number) {
    std::array<OverlapCorner, 4> corners;
    double rounding = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t vertex = reference_.corners[number][k];
      const CellWeights found = of_cell.weights_in(0, vertices_.positions[vertex]);
      double there = 0;
      for (std::size_t i = 0; i < 4; ++i) there += found.weights[i] * (values[i] - low);
      corners[k] = {found.weights, (vertices_.values[vertex] - low) - there};
      rounding = std::max(rounding, found.rounding);
    }
    const std::optional<CellOverlap> found = find_overlap(corners);
    if (!found) return;
    bool is_thick = true;
    for (std::size_t k = 0; k < 4; ++k)
      is_thick = is_thick && found->centre[k] * heights[k] > allowance;
    constexpr double kRounding = 1e-9;
    if (is_thick)
      largest = std::max(largest, found->largest - (4 * rounding + kRounding) * (high - low));
  });
  return largest;
}

TetraOverlayErrors TetraOverlay::measure(const TetraCells& cells, Threads threads) const {
  std::vector<double> found(cells.corners.size());
  parallel_for(found.size(), threads, 16, [&](std::size_t i, int) {
    if (cells.makers[i] != tetra_mt::kNone) found[i] = largest_in(cells.corners[i]);
  });
  TetraOverlayErrors errors;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (cells.makers[i] == tetra_mt::kNone) continue;
    const double stated = cells.stated[i].error;
    ++errors.n_cells;
    errors.largest = std::max(errors.largest, found[i]);
    errors.largest_stated = std::max(errors.largest_stated, stated);
    if (found[i] <= stated) continue;
    ++errors.n_above_stated;
    if (errors.first.empty())
      errors.first = fmt::format("cell {}: |F - F'| {:.6g}, stated {:.6g}", i, found[i], stated);
  }
  return errors;
}

}  // namespace lode
