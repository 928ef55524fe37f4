#include "lode/delaunay/grid_domain.h"

#include <algorithm>
#include <span>
#include <utility>

#include "lode/delaunay/grid_cells.h"
#include "lode/delaunay/triangulation.h"

namespace lode::delaunay {
namespace {

/// The corners of the outline, in rows, and its directed edges between them, the domain to their
/// left.
struct Outline {
  std::vector<LatticePoint> corners;
  std::vector<std::array<std::uint32_t, 2>> edges;
};

Outline trace_outline(const GridCells& cells, std::span<const std::int32_t> side_rows) {
  constexpr std::uint32_t kNobody = 0xffffffff;
  Outline outline;
  const auto is_vertex = [&](std::int32_t x, std::int32_t y) {
    if (cells.is_corner(x, y)) return true;
    const bool is_on_side = (x == 0 || x == cells.n_columns() - 1) && cells.n_round(x, y) == 2;
    return is_on_side && std::ranges::binary_search(side_rows, y);
  };
  // The last corner of each column, where a vertical edge may have begun.
  std::vector<std::uint32_t> above(static_cast<std::size_t>(cells.n_columns()), kNobody);
  for (std::int32_t y = 0; y < cells.n_rows(); ++y) {
    std::uint32_t before = kNobody;
    for (std::int32_t x = 0; x < cells.n_columns(); ++x) {
      if (!is_vertex(x, y)) continue;
      const auto corner = static_cast<std::uint32_t>(outline.corners.size());
      outline.corners.push_back({x, y});
      const bool is_low = cells.has(x - 1, y - 1);
      const bool is_high = cells.has(x - 1, y);
      if (is_high && !is_low) outline.edges.push_back({before, corner});
      if (is_low && !is_high) outline.edges.push_back({corner, before});
      const bool is_left = cells.has(x - 1, y - 1);
      const bool is_right = cells.has(x, y - 1);
      std::uint32_t& start = above[static_cast<std::size_t>(x)];
      if (is_left && !is_right) outline.edges.push_back({start, corner});
      if (is_right && !is_left) outline.edges.push_back({corner, start});
      before = corner;
      start = corner;
    }
  }
  return outline;
}

/// The whole lattice.
GridDomain full_domain(const HeightGrid& grid, const LatticePacking& packing) {
  const std::int32_t x = grid.n_columns - 1;
  const std::int32_t y = grid.n_rows - 1;
  const std::uint32_t a = packing.pack({0, 0});
  const std::uint32_t b = packing.pack({x, 0});
  const std::uint32_t c = packing.pack({x, y});
  const std::uint32_t d = packing.pack({0, y});
  return {{{a, b, c}, {a, c, d}},
          static_cast<std::uint64_t>(std::int64_t{x} * y),
          static_cast<std::uint64_t>(grid.n_samples()),
          0};
}

Result<GridDomain> traced_domain(const HeightGrid& grid, const LatticePacking& packing,
                                 std::span<const std::int32_t> side_rows) {
  const GridCells cells(grid);
  LODE_CHECK(check_cells(cells, grid));
  GridDomain domain;
  LODE_TRY(domain.triangles, triangulate_cells(cells, packing, side_rows));
  domain.n_cells = cells.n_inside();
  domain.n_samples = cells.count_samples();
  domain.n_left_out =
      static_cast<std::uint64_t>(grid.n_samples()) - grid.n_missing() - domain.n_samples;
  return domain;
}

}  // namespace

Result<std::vector<std::array<std::uint32_t, 3>>> triangulate_cells(
    const GridCells& cells, const LatticePacking& packing,
    std::span<const std::int32_t> side_rows) {
  const Outline outline = trace_outline(cells, side_rows);
  std::vector<Point> points;
  points.reserve(outline.corners.size());
  for (const LatticePoint& p : outline.corners)
    points.push_back({{static_cast<double>(p.x), static_cast<double>(p.y)}});
  LODE_TRY(auto triangles, triangulate_region(std::move(points), outline.edges));
  for (auto& triangle : triangles)
    for (std::uint32_t& corner : triangle) corner = packing.pack(outline.corners[corner]);
  return triangles;
}

Result<void> check_lattice(const HeightGrid& grid) {
  if (grid.n_columns < 2 || grid.n_rows < 2)
    return fail("expected at least 2 x 2 samples, got {} x {}, which span no area", grid.n_columns,
                grid.n_rows);
  if (!LatticePacking::fits(grid.n_columns, grid.n_rows))
    return fail("expected columns and rows whose numbers have 32 bits together, got {} x {}",
                grid.n_columns, grid.n_rows);
  return {};
}

Result<void> check_cells(const GridCells& cells, const HeightGrid& grid) {
  if (cells.n_inside() > 0) return {};
  return fail(
      "expected at least one cell with heights at its four corners, got none ({} of {} samples "
      "are missing)",
      grid.n_missing(), grid.n_samples());
}

Result<GridDomain> find_domain(const HeightGrid& grid, std::span<const std::int32_t> side_rows) {
  LODE_CHECK(check_lattice(grid));
  const LatticePacking packing(grid.n_columns);
  if (grid.n_missing() == 0 && side_rows.empty()) return full_domain(grid, packing);
  return traced_domain(grid, packing, side_rows);
}

Result<void> check_heights(const HeightRange& range) {
  constexpr double kLargest = 1e30;
  if (range.lower < -kLargest || range.upper > kLargest)
    return fail(
        "expected heights from {} to {}, got {} to {}: of a number that stands for missing "
        "samples, and that the file does not say, --nodata says it",
        -kLargest, kLargest, range.lower, range.upper);
  return {};
}

}  // namespace lode::delaunay
