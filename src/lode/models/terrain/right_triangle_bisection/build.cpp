#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "lode/models/terrain/right_triangle_bisection/cell_counts.h"
#include "lode/models/terrain/right_triangle_bisection/height_lanes.h"
#include "lode/models/terrain/right_triangle_bisection/nested_errors.h"
#include "lode/models/terrain/right_triangle_bisection/own_errors.h"
#include "lode/models/terrain/right_triangle_bisection/stretched_diamonds.h"
#include "lode/models/terrain/right_triangle_bisection/whole_heights.h"

namespace lode::bisection {
namespace {

constexpr float kAlways = std::numeric_limits<float>::infinity();

/// Heights of a row of a raster without gaps.
template <typename T>
HeightRange range_of_row(const T* row, std::int32_t n, const HeightLanes& lanes) {
  if constexpr (std::is_floating_point_v<T>) return lanes.range(row, n);
  T lower = row[0];
  T upper = row[0];
  for (std::int32_t x = 1; x < n; ++x) {
    lower = std::min(lower, row[x]);
    upper = std::max(upper, row[x]);
  }
  return {static_cast<double>(lower), static_cast<double>(upper)};
}

template <typename T>
HeightRange find_range(const HeightGrid& grid, const RasterRows<T>& rows, Threads threads) {
  if (!grid.is_valid.empty()) return height_range(grid);
  const HeightLanes lanes = height_lanes();
  std::vector<HeightRange> ranges(static_cast<std::size_t>(grid.n_rows));
  parallel_for(ranges.size(), threads, 64, [&](std::size_t y, int) {
    ranges[y] = range_of_row(rows.row(static_cast<std::int32_t>(y)), grid.n_columns, lanes);
  });
  HeightRange all = ranges.front();
  for (const HeightRange& range : ranges) {
    all.lower = std::min(all.lower, range.lower);
    all.upper = std::max(all.upper, range.upper);
  }
  return all;
}

/// Strips, and what they owe to each other's first rows.
template <typename T>
void set_own_errors(const RasterRows<T>& rows, const Lattice& lattice, Threads threads,
                    Progress& progress, float* errors) {
  for (std::int32_t y = 0; y <= lattice.last().y; y += kStripRows)
    for (std::int32_t x = 0; x <= lattice.last().x; x += kStripRows)
      errors[lattice.index({x, y})] = 0;
  const auto n_strips = static_cast<std::size_t>((lattice.last().y + kStripRows - 1) / kStripRows);
  const auto stride = static_cast<std::size_t>(lattice.stride());
  UninitializedArray<float> upper(n_strips * stride);
  const AddStripErrors<T> add_errors = add_strip_errors<T>();
  parallel_for(n_strips, threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    add_errors(rows, lattice, static_cast<std::int32_t>(i) * kStripRows, errors,
               &upper[i * stride]);
  });
  for (std::size_t i = 0; i < n_strips; ++i) {
    const auto y = static_cast<std::int32_t>(i + 1) * kStripRows;
    if (y > lattice.last().y || progress.is_cancelled()) break;
    const bool is_last = y == lattice.last().y;
    float* const row = errors + y * lattice.stride();
    for (std::int32_t x = 0; x <= lattice.last().x; ++x) {
      if (x % kStripRows == 0) continue;
      const float owed = upper[i * stride + static_cast<std::size_t>(x)];
      row[x] = is_last ? owed : std::max(row[x], owed);
    }
  }
}

/// Whether arithmetic of float64 on these heights is exact for all sides of squares: multiples of
/// 2^-8 below 2^22.
template <typename T>
bool is_exact(const HeightGrid& grid, const RasterRows<T>& rows, const HeightRange& range,
              Threads threads) {
  if constexpr (std::is_integral_v<T>) return true;
  if (!(std::max(std::abs(range.lower), std::abs(range.upper)) < 0x1p22)) return false;
  std::vector<std::uint8_t> has_others(static_cast<std::size_t>(grid.n_rows), 0);
  parallel_for(has_others.size(), threads, 64, [&](std::size_t y, int) {
    const T* row = rows.row(static_cast<std::int32_t>(y));
    int n_others = 0;
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const T scaled = row[x] * T{256};
      n_others += static_cast<T>(static_cast<std::int32_t>(scaled)) == scaled ? 0 : 1;
    }
    has_others[y] = n_others > 0 ? 1 : 0;
  });
  return std::ranges::count(has_others, 1) == 0;
}

/// Whether a node and all corners of its diamond have one height.
template <typename T>
bool is_level(const RasterRows<T>& rows, const Lattice& lattice, LatticePoint node) {
  const auto z = [&](LatticePoint p) {
    const LatticePoint place = lattice.place(p);
    return rows.row(place.y)[place.x];
  };
  const Diamond diamond(node);
  const T height = z(node);
  const auto differs = [&](LatticePoint p) { return lattice.has(p) && z(p) != height; };
  return std::ranges::none_of(diamond.ends, differs) &&
         std::ranges::none_of(diamond.apexes, differs);
}

template <typename Visit>
void for_each_bit(const std::vector<std::uint64_t>& words, const Visit& visit) {
  for (std::size_t i = 0; i < words.size(); ++i)
    for (std::uint64_t word = words[i]; word != 0; word &= word - 1)
      visit(static_cast<std::int32_t>(64 * i) + std::countr_zero(word));
}

/// Errors of whole steps in units of heights, and what rounding may have hidden added to them: but
/// where all corners have one height, and no step is in between. Should samples in between differ
/// from these by what is less than a step, nodes that wait for this one say so.
void finish_errors(const RasterRows<double>& rows, const Lattice& lattice, double unit,
                   double slack, Threads threads, float* errors) {
  const auto n = static_cast<std::int32_t>(lattice.stride());
  const std::size_t n_rows = lattice.size() / static_cast<std::size_t>(n);
  const HeightLanes lanes = height_lanes();
  constexpr std::size_t kRows = 64;
  parallel_for((n_rows + kRows - 1) / kRows, threads, 1, [&](std::size_t piece, int) {
    std::vector<std::uint64_t> zeros(static_cast<std::size_t>(n) / 64 + 1);
    for (std::size_t row = piece * kRows; row < std::min(n_rows, (piece + 1) * kRows); ++row) {
      const auto y = static_cast<std::int32_t>(row);
      float* const at = errors + y * lattice.stride();
      lanes.to_units(at, n, unit, slack, zeros.data());
      for_each_bit(zeros, [&](std::int32_t x) {
        const LatticePoint node = lattice.node_at(x, y);
        if (lattice.has(node) && (lattice.is_corner(node) || is_level(rows, lattice, node)))
          at[x] = 0;
      });
    }
  });
}

/// The same of exact ones.
void scale_errors(const Lattice& lattice, double unit, Threads threads, float* errors) {
  constexpr std::size_t kPiece = 1 << 15;
  const std::size_t n = lattice.size();
  const HeightLanes lanes = height_lanes();
  parallel_for((n + kPiece - 1) / kPiece, threads, 1, [&](std::size_t piece, int) {
    const std::size_t first = piece * kPiece;
    std::array<std::uint64_t, kPiece / 64> zeros;
    lanes.to_units(errors + first, static_cast<std::int32_t>(std::min(n - first, kPiece)), unit, 0,
                   zeros.data());
  });
}

/// Adds what rounding may have hidden to all errors but where all corners have one height.
template <typename T>
void add_slack(const RasterRows<T>& rows, const Lattice& lattice, double slack, Threads threads,
               float* errors) {
  parallel_for(static_cast<std::size_t>(lattice.last().y) + 1, threads, 16,
               [&](std::size_t row, int) {
                 const auto y = static_cast<std::int32_t>(row);
                 for (std::int32_t x = 0; x <= lattice.last().x; ++x) {
                   if (lattice.is_corner({x, y})) continue;
                   float& error = errors[lattice.index({x, y})];
                   if (error > 0 || !is_level(rows, lattice, {x, y}))
                     error = delaunay::to_float_above(static_cast<double>(error) + slack);
                 }
               });
}

/// Of all nodes.
template <typename T>
void set_errors(const HeightGrid& grid, const RasterRows<T>& rows, const HeightRange& range,
                const Lattice& lattice, Threads threads, Progress& progress, float* errors) {
  // Missing heights may be anything: then numbers are not looked for.
  const bool may_be_whole = std::is_floating_point_v<T> && grid.is_valid.empty();
  const double slack = 0x1p-46 * std::max(std::abs(range.lower), std::abs(range.upper));
  if constexpr (std::is_floating_point_v<T>)
    if (const auto whole = may_be_whole ? find_whole_heights(rows, lattice.last(), range, threads)
                                        : std::nullopt) {
      const RasterRows<std::uint16_t> steps{whole->samples.data(), whole->stride};
      set_own_errors(steps, lattice, threads, progress, errors);
      if (progress.is_cancelled()) return;
      set_stretched_errors(steps, {0, whole->largest}, true, lattice, threads, errors);
      if constexpr (std::is_same_v<T, double>)
        if (!whole->is_exact) {
          finish_errors(rows, lattice, 1 / whole->per_unit, slack, threads, errors);
          return;
        }
      if (whole->per_unit != 1) scale_errors(lattice, 1 / whole->per_unit, threads, errors);
      return;
    }
  set_own_errors(rows, lattice, threads, progress, errors);
  if (progress.is_cancelled()) return;
  const bool has_exact =
      std::is_integral_v<T> || (may_be_whole && is_exact(grid, rows, range, threads));
  if (!has_exact) add_slack(rows, lattice, slack, threads, errors);
  set_stretched_errors(rows, range, has_exact, lattice, threads, errors);
}

}  // namespace

Result<Bisection> Bisection::build(const HeightGrid& grid, Threads threads, Progress& progress) {
  if (grid.n_columns < 2 || grid.n_rows < 2)
    return fail("expected two columns and rows or more, got {} x {} samples", grid.n_columns,
                grid.n_rows);
  if (!delaunay::LatticePacking::fits(grid.n_columns, grid.n_rows))
    return fail("expected a raster whose columns and rows need up to 32 bits, got {} x {}",
                grid.n_columns, grid.n_rows);
  Bisection made{Lattice(grid.n_columns, grid.n_rows)};
  const Lattice& lattice = made.lattice_;
  if (lattice.index(lattice.last()) > std::numeric_limits<std::uint32_t>::max())
    return fail("expected a raster of up to some 2^32 samples, got {} x {}", grid.n_columns,
                grid.n_rows);
  std::optional<CellCounts> counts;
  if (!grid.is_valid.empty()) {
    made.cells_ = domain_cells(grid);
    counts.emplace(made.cells_, lattice);
    if (counts->all() == 0)
      return fail("expected a cell with four heights, got none in {} x {} samples", grid.n_columns,
                  grid.n_rows);
    if (counts->all() == made.cells_.size()) {
      made.cells_.clear();
      counts.reset();
    }
  }
  made.errors_.resize(lattice.size());
  float* const errors = made.errors_.data();
  const auto find_errors = [&]<typename T>(const HeightGrid::Samples<T>& samples) -> Result<void> {
    const RasterRows<T> rows{samples.data(), grid.stride};
    const HeightRange range = find_range(grid, rows, threads);
    LODE_CHECK(delaunay::check_heights(range));
    set_errors(grid, rows, range, lattice, threads, progress, errors);
    if (progress.is_cancelled()) return cancelled_error();
    return {};
  };
  LODE_CHECK(std::visit(find_errors, grid.heights));
  if (counts) mark_outline(*counts, lattice, threads, errors);
  if (progress.is_cancelled()) return cancelled_error();
  nest_errors(lattice, threads, errors);
  return made;
}

bool Bisection::has_triangle(const std::array<LatticePoint, 3>& corners) const {
  const auto& [a, b, apex] = corners;
  // Both ends are on the side of the apex that the cell is on, or level with it.
  const bool is_left = a.x + b.x < 2 * apex.x || apex.x == lattice_.last().x;
  const bool is_below = a.y + b.y < 2 * apex.y || apex.y == lattice_.last().y;
  return has_cell({apex.x - (is_left ? 1 : 0), apex.y - (is_below ? 1 : 0)});
}

bool Bisection::has_node(LatticePoint p) const {
  for (const std::int32_t y : {p.y - 1, p.y})
    for (const std::int32_t x : {p.x - 1, p.x})
      if (x >= 0 && y >= 0 && x < lattice_.last().x && y < lattice_.last().y && has_cell({x, y}))
        return true;
  return false;
}

void Bisection::keep(std::vector<LatticePoint> nodes) {
  std::vector<LatticePoint> waiting;
  for (const LatticePoint node : nodes)
    if (!lattice_.is_under_corner(node)) waiting.push_back(node);
  while (!waiting.empty()) {
    const LatticePoint node = waiting.back();
    waiting.pop_back();
    float& error = errors_[lattice_.index(node)];
    if (error == kAlways) continue;
    error = kAlways;
    const Diamond diamond(node);
    for (const LatticePoint apex : diamond.apexes)
      if (lattice_.has_node(apex, diamond.apex_reach())) waiting.push_back(apex);
  }
  kept_ = std::move(nodes);
}

}  // namespace lode::bisection
