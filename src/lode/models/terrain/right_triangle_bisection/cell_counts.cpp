#include "lode/models/terrain/right_triangle_bisection/cell_counts.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "lode/models/terrain/right_triangle_bisection/nested_errors.h"

namespace lode::bisection {
namespace {

enum class Share : std::uint8_t { none, some, all };

Share share_of(std::uint64_t n, std::uint64_t of) {
  if (n == 0) return Share::none;
  return n == of ? Share::all : Share::some;
}

/// Of a diamond whose sides are diagonals: its cells, row by row.
Share share_of_rows(const CellCounts& counts, const Lattice& lattice, const Diamond& diamond) {
  const LatticePoint p = diamond.node;
  const std::int32_t first = std::max(p.y - diamond.reach, 0);
  const std::int32_t end = std::min(p.y + diamond.reach, lattice.last().y);
  std::uint64_t n = 0;
  std::uint64_t of = 0;
  for (std::int32_t y = first; y < end; ++y) {
    const std::int32_t width = diamond.reach - (y >= p.y ? y - p.y : p.y - 1 - y);
    const std::int32_t left = std::max(p.x - width, 0);
    const std::int32_t right = std::min(p.x + width, lattice.last().x);
    n += counts.between({left, y}, {right, y + 1});
    of += static_cast<std::uint64_t>(right - left);
  }
  return share_of(n, of);
}

Share share_of(const CellCounts& counts, const Lattice& lattice, const Diamond& diamond) {
  const LatticePoint p = diamond.node;
  const LatticePoint lower{std::max(p.x - diamond.reach, 0), std::max(p.y - diamond.reach, 0)};
  const LatticePoint upper = lattice.place({p.x + diamond.reach, p.y + diamond.reach});
  const Share of_box =
      share_of(counts.between(lower, upper),
               static_cast<std::uint64_t>(std::int64_t{upper.x - lower.x} * (upper.y - lower.y)));
  if (of_box != Share::some || diamond.is_square || lattice.is_stretched(p, diamond.reach))
    return of_box;
  return share_of_rows(counts, lattice, diamond);
}

}  // namespace

std::vector<std::uint8_t> domain_cells(const HeightGrid& grid) {
  std::vector<std::uint8_t> cells;
  cells.reserve(static_cast<std::size_t>(std::int64_t{grid.n_columns - 1} * (grid.n_rows - 1)));
  for (std::int32_t y = 0; y + 1 < grid.n_rows; ++y)
    for (std::int32_t x = 0; x + 1 < grid.n_columns; ++x) {
      const bool has_all = grid.has_height(x, y) && grid.has_height(x + 1, y) &&
                           grid.has_height(x, y + 1) && grid.has_height(x + 1, y + 1);
      cells.push_back(has_all ? 1 : 0);
    }
  return cells;
}

CellCounts::CellCounts(const std::vector<std::uint8_t>& cells, const Lattice& lattice)
    : width_(lattice.last().x + 1) {
  sums_.resize(static_cast<std::size_t>(width_ * (std::int64_t{lattice.last().y} + 1)), 0);
  std::size_t cell = 0;
  for (std::int64_t y = 1; y <= lattice.last().y; ++y) {
    std::uint32_t in_row = 0;
    for (std::int64_t x = 1; x < width_; ++x) {
      in_row += cells[cell++];
      sums_[static_cast<std::size_t>(y * width_ + x)] =
          sums_[static_cast<std::size_t>((y - 1) * width_ + x)] + in_row;
    }
  }
}

void mark_outline(const CellCounts& counts, const Lattice& lattice, Threads threads,
                  float* errors) {
  for (std::int32_t reach = 1; 2 * reach <= lattice.side(); reach *= 2) {
    const auto mark = [&](LatticePoint node) {
      const Share share = share_of(counts, lattice, Diamond(node));
      float& error = errors[lattice.index(node)];
      if (share == Share::none) error = 0;
      if (share == Share::some) error = std::numeric_limits<float>::infinity();
    };
    for_each_node(lattice, reach, NodeKind::side, threads, mark);
    for_each_node(lattice, reach, NodeKind::square, threads, mark);
  }
}

}  // namespace lode::bisection
