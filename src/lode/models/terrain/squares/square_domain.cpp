#include "lode/models/terrain/squares/square_domain.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "lode/delaunay/grid_domain.h"

namespace lode::squares {
namespace {

/// Of the cells.
std::vector<Share> cell_shares(const HeightGrid& grid) {
  std::vector<Share> shares;
  for (std::int32_t y = 0; y + 1 < grid.n_rows; ++y)
    for (std::int32_t x = 0; x + 1 < grid.n_columns; ++x) {
      const bool is_in = grid.has_height(x, y) && grid.has_height(x + 1, y) &&
                         grid.has_height(x, y + 1) && grid.has_height(x + 1, y + 1);
      shares.push_back(is_in ? Share::all : Share::none);
    }
  return shares;
}

/// The largest power of two that a height other than 0 is a multiple of.
double unit_of(double height) {
  constexpr int kMantissaBits = 52;
  constexpr std::uint64_t kHiddenBit = std::uint64_t{1} << kMantissaBits;
  const auto bits = std::bit_cast<std::uint64_t>(height);
  const auto exponent = static_cast<int>((bits >> kMantissaBits) & 0x7FF);
  const std::uint64_t mantissa =
      (bits & (kHiddenBit - 1)) | (exponent == 0 ? std::uint64_t{0} : kHiddenBit);
  constexpr int kBias = 1023 + kMantissaBits;
  return std::ldexp(1.0, std::max(exponent, 1) - kBias + std::countr_zero(mantissa));
}

/// Whether errors in a square of heights that are multiples of a unit, and differ by no more than
/// `range`, are exact in float64: all numbers are multiples of unit / side², and below 16 ranges.
bool is_exact(double unit, double range, std::int32_t level) {
  constexpr double kNoUnderflow = 0x1p-900;
  return unit >= kNoUnderflow && std::ldexp(range, 2 * level + 4) <= std::ldexp(unit, 53);
}

}  // namespace

Result<SquareDomain> SquareDomain::make(const HeightGrid& grid) {
  SquareDomain domain;
  LODE_CHECK(delaunay::check_heights(height_range(grid)));
  domain.size_x_ = grid.n_columns;
  domain.size_y_ = grid.n_rows;
  if (grid.n_columns < 2 || grid.n_rows < 2)
    return fail("expected a cell with four heights, got {} x {} samples", grid.n_columns,
                grid.n_rows);
  domain.shares_.push_back(cell_shares(grid));
  if (std::ranges::find(domain.shares_[0], Share::all) == domain.shares_[0].end())
    return fail("expected a cell with four heights, got none of {} x {} samples", grid.n_columns,
                grid.n_rows);
  domain.range_ = height_range(grid);
  domain.unit_ = HUGE_VAL;
  domain.heights_.reserve(static_cast<std::size_t>(grid.n_samples()));
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const double height = grid.has_height(x, y) ? grid.height(x, y) : 0;
      domain.heights_.push_back(height);
      if (height != 0) domain.unit_ = std::min(domain.unit_, unit_of(height));
    }
  while (domain.n_columns(domain.n_levels() - 1) > 1 || domain.n_rows(domain.n_levels() - 1) > 1) {
    const std::int32_t level = domain.n_levels();
    std::vector<Share> shares;
    for (std::int32_t row = 0; row < domain.n_rows(level); ++row)
      for (std::int32_t column = 0; column < domain.n_columns(level); ++column) {
        const Square square{level, column, row};
        bool has_any = false;
        bool has_all = true;
        for (int i = 0; i < 4; ++i) {
          const Share share = domain.share(square.child(i));
          has_any = has_any || share != Share::none;
          has_all = has_all && share == Share::all;
        }
        shares.push_back(has_all ? Share::all : has_any ? Share::some : Share::none);
      }
    domain.shares_.push_back(std::move(shares));
  }
  return domain;
}

double SquareDomain::rounding_in(const Square& q, SquarePart part) const {
  if (is_exact(unit_, range_.upper - range_.lower, q.level)) return 0;
  double lower = height(q.x(), q.y());
  double upper = lower;
  for (std::int32_t v = 0; v <= q.side(); ++v) {
    const double* const begin = row(q.y() + v) + q.x();
    const auto [least, most] =
        std::minmax_element(begin + (part == SquarePart::lower ? v : 0),
                            begin + (part == SquarePart::upper ? v : q.side()) + 1);
    lower = std::min(lower, *least);
    upper = std::max(upper, *most);
  }
  const double range = upper - lower;
  if (range == 0 || is_exact(unit_, range, q.level)) return 0;
  // Heights less another are off by half a unit of the range in the last place, slopes times whole
  // numbers by up to 8, their sum by 17, the error by 20, as docs/models/quadtrees.md counts; 32
  // have room for the sum of error and slack. What underflows is no more than the last term.
  return 32 * 0x1p-53 * range + 0x1p-1000;
}

namespace {

bool is_before(LatticePoint a, LatticePoint b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

/// Adds a node to the counts of a square that it lies in, by its place from the lower left corner.
void count_kept(std::int32_t u, std::int32_t v, std::int32_t side, KeptCounts& counts) {
  const bool is_first = u == 0 && v == 0;
  const bool is_last = u == side && v == side;
  const bool is_right = u == side && v == 0;
  const bool is_left = u == 0 && v == side;
  if (is_first || is_last) return;
  if (v <= u && !is_right) ++counts.lower;
  if (v >= u && !is_left) ++counts.upper;
  if (!is_right && !is_left) ++counts.all;
}

}  // namespace

void SquareDomain::keep(std::vector<LatticePoint> nodes) {
  kept_ = std::move(nodes);
  kept_in_.clear();
  for (std::int32_t level = 0; level < n_levels() && !kept_.empty(); ++level) {
    auto& counts = kept_in_.emplace_back(n_squares(level));
    const std::int32_t side = std::int32_t{1} << level;
    for (const LatticePoint p : kept_)
      for (std::int32_t row = (p.y - 1) >> level; row <= p.y >> level; ++row)
        for (std::int32_t column = (p.x - 1) >> level; column <= p.x >> level; ++column) {
          const Square square{level, column, row};
          if (has(square))
            count_kept(p.x - square.x(), p.y - square.y(), side, counts[index(square)]);
        }
  }
}

bool SquareDomain::is_kept(LatticePoint p) const {
  return std::ranges::binary_search(kept_, p, is_before);
}

bool SquareDomain::has_node(LatticePoint p) const {
  for (int i = 0; i < 4; ++i)
    if (share({0, p.x - (i & 1), p.y - (i >> 1)}) == Share::all) return true;
  return false;
}

}  // namespace lode::squares
