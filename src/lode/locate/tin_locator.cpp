#include "lode/locate/tin_locator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/core/expects.h"
#include "lode/delaunay/lattice_side.h"

namespace lode {
namespace {

using delaunay::LatticePoint;
using delaunay::Point;

/// Of a walk within a square, beyond what its triangles may take.
constexpr std::size_t kShortWalk = 64;
constexpr std::array<std::uint32_t, 3> kNext{1, 2, 0};
/// Triangles a square has, were they all alike. 2 to 8 cost about the same time.
constexpr double kPerSquare = 4;

/// From the left end to the right end of what a band of rows cuts out of a triangle.
struct Extent {
  double left;
  double right;
};

Extent extent_in(const std::array<LatticePoint, 3>& corner, double low, double high) {
  Extent extent{INFINITY, -INFINITY};
  const auto add = [&](double x, double rounding) {
    extent.left = std::min(extent.left, x - rounding);
    extent.right = std::max(extent.right, x + rounding);
  };
  // More than it can be: coordinates are below 2^30.
  constexpr double kOffset = 0x1p-20;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point a = delaunay::to_point(corner[i]);
    const Point b = delaunay::to_point(corner[kNext[i]]);
    if (low <= a[1] && a[1] <= high) add(a[0], 0);
    for (const double y : {low, high})
      if ((a[1] < y) != (b[1] < y))
        add(a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])), kOffset);
  }
  return extent;
}

}  // namespace

TinLocator::TinLocator(const delaunay::Tin& tin) : tin_(tin) {
  LODE_EXPECTS(!tin.triangles.empty() && tin.twins.size() == tin.triangles.size());
  choose_size();
  fill_squares();
}

void TinLocator::choose_size() {
  lower_ = upper_ = tin_.vertices.front();
  for (const LatticePoint& p : tin_.vertices) {
    lower_ = {std::min(lower_.x, p.x), std::min(lower_.y, p.y)};
    upper_ = {std::max(upper_.x, p.x), std::max(upper_.y, p.y)};
  }
  const double area = double{upper_.x - lower_.x + 1.0} * (upper_.y - lower_.y + 1.0);
  const double wanted = area * kPerSquare / static_cast<double>(tin_.triangles.size());
  while (std::ldexp(1, 2 * bits_) < wanted) ++bits_;
  n_columns_ = ((upper_.x - lower_.x) >> bits_) + 1;
  n_rows_ = ((upper_.y - lower_.y) >> bits_) + 1;
}

template <typename Visit>
void TinLocator::visit_squares(std::uint32_t triangle, const Visit& visit) const {
  std::array<LatticePoint, 3> corner{};
  for (std::size_t i = 0; i < 3; ++i) corner[i] = tin_.vertices[tin_.triangles[triangle][i]];
  const auto [low, high] = std::minmax({corner[0].y, corner[1].y, corner[2].y});
  const auto column = [&](double x) {
    const double inside = std::clamp(x - lower_.x, 0.0, double{upper_.x - lower_.x + 0.0});
    return static_cast<std::int32_t>(inside) >> bits_;
  };
  for (std::int32_t row = (low - lower_.y) >> bits_; row <= (high - lower_.y) >> bits_; ++row) {
    const double bottom = lower_.y + std::ldexp(row, bits_);
    const Extent extent = extent_in(corner, bottom, bottom + std::ldexp(1, bits_));
    for (std::int32_t x = column(extent.left); x <= column(extent.right); ++x)
      visit(static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(n_columns_) +
            static_cast<std::uint32_t>(x));
  }
}

void TinLocator::fill_squares() {
  const auto n = static_cast<std::uint32_t>(tin_.triangles.size());
  first_.assign(std::size_t{n_squares()} + 1, 0);
  for (std::uint32_t t = 0; t < n; ++t)
    visit_squares(t, [&](std::uint32_t square) { ++first_[square + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  entries_.resize(first_.back());
  std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < n; ++t)
    visit_squares(t, [&](std::uint32_t square) { entries_[next[square]++] = t; });
}

bool TinLocator::is_in_rectangle(const Point& p) const {
  return p[0] >= lower_.x && p[0] <= upper_.x && p[1] >= lower_.y && p[1] <= upper_.y;
}

std::uint32_t TinLocator::square_of(const Point& p) const {
  const auto column = static_cast<std::uint32_t>(p[0] - lower_.x) >> bits_;
  const auto row = static_cast<std::uint32_t>(p[1] - lower_.y) >> bits_;
  return row * static_cast<std::uint32_t>(n_columns_) + column;
}

std::span<const std::uint32_t> TinLocator::triangles_in(std::uint32_t square) const {
  return {entries_.data() + first_[square], entries_.data() + first_[square + 1]};
}

bool TinLocator::holds(std::uint32_t triangle, const Point& p) const {
  const auto& corner = tin_.triangles[triangle];
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::side_of(tin_.vertices[corner[i]], tin_.vertices[corner[kNext[i]]], p) < 0)
      return false;
  return true;
}

bool TinLocator::is_on_edge(std::uint32_t triangle, const Point& p) const {
  const auto& corner = tin_.triangles[triangle];
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::side_of(tin_.vertices[corner[i]], tin_.vertices[corner[kNext[i]]], p) == 0)
      return true;
  return false;
}

std::optional<std::uint32_t> TinLocator::first_with(std::span<const std::uint32_t> near,
                                                    const Point& p) const {
  for (const std::uint32_t one : near)
    if (holds(one, p)) return one;
  return std::nullopt;
}

std::optional<std::uint32_t> TinLocator::find(const Point& p) const {
  if (!is_in_rectangle(p)) return std::nullopt;
  const std::span<const std::uint32_t> near = triangles_in(square_of(p));
  if (near.empty()) return std::nullopt;
  std::uint32_t t = near[0];
  std::uint32_t entered = 0;  // The edge that it came through, after the first step.
  // Where edges are not Delaunay it may turn in circles.
  std::size_t n_left = 2 * near.size() + kShortWalk;
  for (bool is_first = true; n_left > 0; is_first = false, --n_left) {
    const auto& corner = tin_.triangles[t];
    std::uint32_t out = 3;
    for (std::uint32_t k = 0; k < 3 && out == 3; ++k) {
      const std::uint32_t i = (entered + k) % 3;
      if (!is_first && k == 0) continue;
      if (delaunay::side_of(tin_.vertices[corner[i]], tin_.vertices[corner[kNext[i]]], p) < 0)
        out = i;
    }
    if (out == 3) return is_on_edge(t, p) ? first_with(near, p) : t;
    const std::uint32_t twin = tin_.twins[t][out];
    if (twin == delaunay::kNoHalfEdge) break;
    t = twin / 4;
    entered = twin % 4;
  }
  return first_with(near, p);
}

std::vector<std::uint32_t> TinLocator::find_all(const Point& p) const {
  std::vector<std::uint32_t> all;
  if (!is_in_rectangle(p)) return all;
  for (const std::uint32_t one : triangles_in(square_of(p)))
    if (holds(one, p)) all.push_back(one);
  return all;
}

}  // namespace lode
