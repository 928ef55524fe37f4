#include "lode/locate/plane_locator.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "lode/core/expects.h"

namespace lode {
namespace {

using delaunay::Point;

/// Triangles a square has, were they all alike, and squares along the longer side at most.
constexpr double kAlike = 4;
constexpr double kMostAlong = 0x1p20;
/// Triangles of a square that is cut again, in no more squares than so many times their number;
/// squares inside one another; and their side as a share of the largest coordinate.
constexpr std::uint64_t kCrowd = 64;
constexpr std::uint64_t kMostTimes = 8;
constexpr int kMostDepth = 8;
constexpr double kFinest = 0x1p-30;
/// Of a square, more than rounding in coordinates of squares can be.
constexpr double kMargin = 0x1p-10;

/// From the left end to the right end of what a band of rows cuts out of a triangle.
struct Cut {
  double left = INFINITY;
  double right = -INFINITY;

  void add(double x) {
    left = std::min(left, x - kMargin);
    right = std::max(right, x + kMargin);
  }
};

/// Coordinates of squares.
Cut cut_of(const std::array<Point, 3>& corner, double low, double high) {
  Cut cut;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& a = corner[i];
    const Point& b = corner[(i + 1) % 3];
    if (low <= a[1] && a[1] <= high) cut.add(a[0]);
    for (const double y : {low, high})
      if ((a[1] < y) != (b[1] < y)) cut.add(a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])));
  }
  return cut;
}

std::int64_t whole_below(double place, std::size_t n) {
  return static_cast<std::int64_t>(std::clamp(place, 0.0, static_cast<double>(n - 1)));
}

}  // namespace

PlaneLocator::PlaneLocator(std::span<const Point> vertices, std::span<const Triangle> triangles)
    : vertices_(vertices), triangles_(triangles) {
  LODE_EXPECTS(!triangles.empty());
  lower_ = upper_ = vertices_[triangles_.front()[0]];
  for (const Triangle& triangle : triangles_)
    for (const std::uint32_t v : triangle)
      for (std::size_t axis = 0; axis < 2; ++axis) {
        lower_[axis] = std::min(lower_[axis], vertices_[v][axis]);
        upper_[axis] = std::max(upper_[axis], vertices_[v][axis]);
      }
  std::vector<std::uint32_t> all(triangles.size());
  std::iota(all.begin(), all.end(), std::uint32_t{0});
  squares_ = *squares_of(lower_, upper_, all, 0);
}

std::size_t PlaneLocator::Squares::square_of(const Point& p) const {
  const auto column = whole_below((p[0] - lower[0]) * per_unit, n_columns);
  const auto row = whole_below((p[1] - lower[1]) * per_unit, n_rows);
  return static_cast<std::size_t>(row) * n_columns + static_cast<std::size_t>(column);
}

std::span<const std::uint32_t> PlaneLocator::triangles_near(const Point& p) const {
  const Squares* squares = &squares_;
  for (;;) {
    const std::size_t square = squares->square_of(p);
    const auto finer = squares->finer.find(square);
    if (finer == squares->finer.end())
      return std::span(squares->entries)
          .subspan(squares->first[square], squares->first[square + 1] - squares->first[square]);
    squares = &finer->second;
  }
}

template <typename Visit>
void PlaneLocator::visit_squares(const Squares& squares, std::uint32_t triangle,
                                 const Visit& visit) const {
  const std::size_t n_columns = squares.n_columns;
  const std::size_t n_rows = squares.n_rows;
  std::array<Point, 3> corner;
  for (std::size_t i = 0; i < 3; ++i)
    corner[i] = (vertices_[triangles_[triangle][i]] - squares.lower) * squares.per_unit;
  const auto [low, high] = std::minmax({corner[0][1], corner[1][1], corner[2][1]});
  for (std::int64_t row = whole_below(low, n_rows); row <= whole_below(high, n_rows); ++row) {
    const auto bottom = static_cast<double>(row);
    const Cut cut = cut_of(corner, bottom - kMargin, bottom + 1 + kMargin);
    for (std::int64_t x = whole_below(cut.left, n_columns); x <= whole_below(cut.right, n_columns);
         ++x)
      visit(static_cast<std::size_t>(row) * n_columns + static_cast<std::size_t>(x));
  }
}

std::optional<PlaneLocator::Squares> PlaneLocator::squares_of(
    const Point& lower, const Point& upper, std::span<const std::uint32_t> triangles,
    int depth) const {
  Squares squares;
  squares.lower = lower;
  const Point size = upper - lower;
  const double longer = std::max(size[0], size[1]);
  const double side = std::sqrt(size[0] * size[1] * kAlike / static_cast<double>(triangles.size()));
  squares.per_unit = 1 / std::max(side, longer / kMostAlong);
  squares.n_columns = static_cast<std::size_t>(size[0] * squares.per_unit) + 1;
  squares.n_rows = static_cast<std::size_t>(size[1] * squares.per_unit) + 1;
  squares.first.assign(squares.n_columns * squares.n_rows + 1, 0);
  const std::uint64_t most = depth == 0 ? UINT64_MAX : kMostTimes * triangles.size();
  std::uint64_t n = 0;
  for (const std::uint32_t t : triangles) {
    visit_squares(squares, t, [&](std::size_t square) {
      ++squares.first[square + 1];
      ++n;
    });
    if (n > most) return std::nullopt;
  }
  for (std::size_t i = 1; i < squares.first.size(); ++i) squares.first[i] += squares.first[i - 1];
  squares.entries.resize(squares.first.back());
  std::vector<std::uint64_t> next(squares.first.begin(), squares.first.end() - 1);
  for (const std::uint32_t t : triangles)
    visit_squares(squares, t, [&](std::size_t square) { squares.entries[next[square]++] = t; });
  cut_crowded(squares, depth);
  return squares;
}

void PlaneLocator::cut_crowded(Squares& squares, int depth) const {
  const double farthest = std::max(
      {std::abs(lower_[0]), std::abs(lower_[1]), std::abs(upper_[0]), std::abs(upper_[1])});
  // Smaller ones would be lost in the rounding of coordinates.
  if (depth >= kMostDepth || 1 / squares.per_unit < farthest * kFinest) return;
  const double margin = kMargin / squares.per_unit;
  for (std::size_t square = 0; square + 1 < squares.first.size(); ++square) {
    const std::uint64_t n = squares.first[square + 1] - squares.first[square];
    if (n < kCrowd) continue;
    const std::size_t row = square / squares.n_columns;
    const Point place{{static_cast<double>(square % squares.n_columns), static_cast<double>(row)}};
    const Point lower = squares.lower + place * (1 / squares.per_unit) - Point{{margin, margin}};
    const double side = 1 / squares.per_unit + 2 * margin;
    const auto own =
        std::span<const std::uint32_t>(squares.entries).subspan(squares.first[square], n);
    if (auto finer = squares_of(lower, lower + Point{{side, side}}, own, depth + 1))
      squares.finer.emplace(square, std::move(*finer));
  }
}

bool PlaneLocator::holds(std::uint32_t triangle, const Point& p) const {
  const Triangle& corner = triangles_[triangle];
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::orientation(vertices_[corner[i]], vertices_[corner[(i + 1) % 3]], p) < 0)
      return false;
  return true;
}

}  // namespace lode
