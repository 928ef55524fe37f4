#include "lode/delaunay/grid_domain.h"

#include <algorithm>
#include <span>
#include <utility>

#include "lode/delaunay/triangulation.h"

namespace lode::delaunay {
namespace {

/// Which cells have four valid corners, with a border of cells outside all round.
class Cells {
 public:
  explicit Cells(const HeightGrid& grid)
      : n_columns_(grid.n_columns),
        n_rows_(grid.n_rows),
        is_inside_(static_cast<std::size_t>(grid.n_columns + 1) *
                   static_cast<std::size_t>(grid.n_rows + 1)) {
    for (std::int32_t y = 0; y + 1 < n_rows_; ++y)
      for (std::int32_t x = 0; x + 1 < n_columns_; ++x)
        if (grid.has_height(x, y) && grid.has_height(x + 1, y) && grid.has_height(x, y + 1) &&
            grid.has_height(x + 1, y + 1)) {
          is_inside_[at(x, y)] = 1;
          ++n_inside_;
        }
  }
  /// The cell between columns x, x + 1 and rows y, y + 1; -1 and the last ones are outside.
  [[nodiscard]] bool has(std::int32_t x, std::int32_t y) const { return is_inside_[at(x, y)] != 0; }
  [[nodiscard]] std::uint64_t n_inside() const { return n_inside_; }
  /// Of the four cells round a node.
  [[nodiscard]] int n_round(std::int32_t x, std::int32_t y) const {
    return int{has(x - 1, y - 1)} + int{has(x, y - 1)} + int{has(x - 1, y)} + int{has(x, y)};
  }
  /// Whether the outline turns at a node, or touches itself there.
  [[nodiscard]] bool is_corner(std::int32_t x, std::int32_t y) const {
    const int n = n_round(x, y);
    return n == 1 || n == 3 || (n == 2 && has(x - 1, y - 1) == has(x, y));
  }

 private:
  [[nodiscard]] std::size_t at(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(n_columns_ + 1) +
           static_cast<std::size_t>(x + 1);
  }

  std::int32_t n_columns_;
  std::int32_t n_rows_;
  std::vector<std::uint8_t> is_inside_;
  std::uint64_t n_inside_ = 0;
};

/// The corners of the outline, in rows, and its directed edges between them, the domain to their
/// left.
struct Outline {
  std::vector<LatticePoint> corners;
  std::vector<std::array<std::uint32_t, 2>> edges;
};

Outline trace_outline(const Cells& cells, const HeightGrid& grid) {
  constexpr std::uint32_t kNobody = 0xffffffff;
  Outline outline;
  // The last corner of each column, where a vertical edge may have begun.
  std::vector<std::uint32_t> above(static_cast<std::size_t>(grid.n_columns), kNobody);
  for (std::int32_t y = 0; y < grid.n_rows; ++y) {
    std::uint32_t before = kNobody;
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      if (!cells.is_corner(x, y)) continue;
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

std::uint64_t count_samples(const Cells& cells, const HeightGrid& grid) {
  std::uint64_t n = 0;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      n += static_cast<std::uint64_t>(cells.n_round(x, y) > 0);
  return n;
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

Result<GridDomain> masked_domain(const HeightGrid& grid, const LatticePacking& packing) {
  const Cells cells(grid);
  if (cells.n_inside() == 0)
    return fail(
        "expected at least one cell with heights at its four corners, got none ({} of {} samples "
        "are missing)",
        grid.n_missing(), grid.n_samples());
  const Outline outline = trace_outline(cells, grid);
  std::vector<Point> points;
  points.reserve(outline.corners.size());
  for (const LatticePoint& p : outline.corners)
    points.push_back({{static_cast<double>(p.x), static_cast<double>(p.y)}});
  LODE_TRY(const auto triangles, triangulate_region(std::move(points), outline.edges));
  GridDomain domain;
  domain.triangles.reserve(triangles.size());
  for (const auto& triangle : triangles) {
    std::array<std::uint32_t, 3> packed{};
    for (std::size_t i = 0; i < 3; ++i) packed[i] = packing.pack(outline.corners[triangle[i]]);
    domain.triangles.push_back(packed);
  }
  domain.n_cells = cells.n_inside();
  domain.n_samples = count_samples(cells, grid);
  domain.n_left_out =
      static_cast<std::uint64_t>(grid.n_samples()) - grid.n_missing() - domain.n_samples;
  return domain;
}

}  // namespace

Result<GridDomain> find_domain(const HeightGrid& grid) {
  if (grid.n_columns < 2 || grid.n_rows < 2)
    return fail("expected at least 2 x 2 samples, got {} x {}, which span no area", grid.n_columns,
                grid.n_rows);
  if (!LatticePacking::fits(grid.n_columns, grid.n_rows))
    return fail("expected columns and rows whose numbers have 32 bits together, got {} x {}",
                grid.n_columns, grid.n_rows);
  const LatticePacking packing(grid.n_columns);
  if (grid.n_missing() == 0) return full_domain(grid, packing);
  return masked_domain(grid, packing);
}

Result<void> check_heights(const HeightRange& range) {
  constexpr double kLargest = 1e30;
  if (range.lower < -kLargest || range.upper > kLargest)
    return fail("expected heights from {} to {}, got {} to {}", -kLargest, kLargest, range.lower,
                range.upper);
  return {};
}

}  // namespace lode::delaunay
