#include "lode/locate/plane_locator.h"

#include <algorithm>
#include <cmath>

#include "lode/core/expects.h"

namespace lode {
namespace {

using delaunay::Point;

/// Triangles a square has, were they all alike, and squares along the longer side at most.
constexpr double kAlike = 4;
constexpr double kMostAlong = 0x1p20;
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
  choose_size();
  fill_squares();
}

void PlaneLocator::choose_size() {
  lower_ = upper_ = vertices_[triangles_.front()[0]];
  for (const Triangle& triangle : triangles_)
    for (const std::uint32_t v : triangle)
      for (std::size_t axis = 0; axis < 2; ++axis) {
        lower_[axis] = std::min(lower_[axis], vertices_[v][axis]);
        upper_[axis] = std::max(upper_[axis], vertices_[v][axis]);
      }
  const Point size = upper_ - lower_;
  const double longer = std::max(size[0], size[1]);
  const double side =
      std::sqrt(size[0] * size[1] * kAlike / static_cast<double>(triangles_.size()));
  per_unit_ = 1 / std::max(side, longer / kMostAlong);
  n_columns_ = static_cast<std::size_t>(size[0] * per_unit_) + 1;
  n_rows_ = static_cast<std::size_t>(size[1] * per_unit_) + 1;
}

std::int64_t PlaneLocator::column_of(double x) const {
  return whole_below((x - lower_[0]) * per_unit_, n_columns_);
}

std::int64_t PlaneLocator::row_of(double y) const {
  return whole_below((y - lower_[1]) * per_unit_, n_rows_);
}

template <typename Visit>
void PlaneLocator::visit_squares(std::uint32_t triangle, const Visit& visit) const {
  std::array<Point, 3> corner;
  for (std::size_t i = 0; i < 3; ++i)
    corner[i] = (vertices_[triangles_[triangle][i]] - lower_) * per_unit_;
  const auto [low, high] = std::minmax({corner[0][1], corner[1][1], corner[2][1]});
  for (std::int64_t row = whole_below(low, n_rows_); row <= whole_below(high, n_rows_); ++row) {
    const auto bottom = static_cast<double>(row);
    const Cut cut = cut_of(corner, bottom - kMargin, bottom + 1 + kMargin);
    for (std::int64_t x = whole_below(cut.left, n_columns_);
         x <= whole_below(cut.right, n_columns_); ++x)
      visit(static_cast<std::size_t>(row) * n_columns_ + static_cast<std::size_t>(x));
  }
}

void PlaneLocator::fill_squares() {
  const auto n = static_cast<std::uint32_t>(triangles_.size());
  first_.assign(n_columns_ * n_rows_ + 1, 0);
  for (std::uint32_t t = 0; t < n; ++t)
    visit_squares(t, [&](std::size_t square) { ++first_[square + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  entries_.resize(first_.back());
  std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < n; ++t)
    visit_squares(t, [&](std::size_t square) { entries_[next[square]++] = t; });
}

bool PlaneLocator::holds(std::uint32_t triangle, const Point& p) const {
  const Triangle& corner = triangles_[triangle];
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::orientation(vertices_[corner[i]], vertices_[corner[(i + 1) % 3]], p) < 0)
      return false;
  return true;
}

}  // namespace lode
