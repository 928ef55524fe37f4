#include "lode/mappers/tin_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/core/expects.h"
#include "lode/delaunay/triangle_rows.h"

namespace lode {
namespace {

using delaunay::LatticePoint;

/// A plane over the nodes of a row. Weights are integers below 2^33, exact; heights are corner 0's
/// and what the other two are above it, of which each takes its share.
class PlaneRow {
 public:
  PlaneRow(const std::array<LatticePoint, 3>& at, const std::array<double, 3>& z)
      : at_(at),
        z_(z[0]),
        rise_{z[1] - z[0], z[2] - z[0]},
        area_(static_cast<double>(delaunay::doubled_area(at[0], at[1], at[2]))) {}

  /// Columns first to last of row y, at `out`.
  void fill(std::int32_t y, std::int32_t first, std::int32_t last, double* out) const {
    const LatticePoint p{first, y};
    auto second = delaunay::doubled_area(at_[2], at_[0], p);
    auto third = delaunay::doubled_area(at_[0], at_[1], p);
    const std::int64_t second_step = at_[2].y - at_[0].y;
    const std::int64_t third_step = at_[0].y - at_[1].y;
    for (std::int32_t x = first; x <= last; ++x) {
      *out++ =
          z_ +
          (static_cast<double>(second) * rise_[0] + static_cast<double>(third) * rise_[1]) / area_;
      second += second_step;
      third += third_step;
    }
  }

 private:
  std::array<LatticePoint, 3> at_;
  double z_;
  std::array<double, 2> rise_;
  double area_;
};

}  // namespace

TinRaster::TinRaster(const delaunay::Tin& tin, std::int32_t n_columns, std::int32_t n_rows)
    : tin_(tin), n_columns_(n_columns), n_rows_(n_rows) {
  LODE_EXPECTS(tin.heights.size() == tin.vertices.size());
  count_strips();
  find_rounding();
}

std::int32_t TinRaster::n_strips() const { return (n_rows_ + kStripRows - 1) / kStripRows; }

std::int32_t TinRaster::n_rows(std::int32_t strip) const {
  return std::min(kStripRows, n_rows_ - first_row(strip));
}

void TinRaster::count_strips() {
  const auto for_each_strip = [&](const auto& visit) {
    for (std::uint32_t t = 0; t < tin_.triangles.size(); ++t) {
      const auto& corner = tin_.triangles[t];
      const auto [low, high] = std::minmax(
          {tin_.vertices[corner[0]].y, tin_.vertices[corner[1]].y, tin_.vertices[corner[2]].y});
      for (std::int32_t s = low / kStripRows; s <= high / kStripRows; ++s)
        visit(t, static_cast<std::size_t>(s));
    }
  };
  first_.assign(static_cast<std::size_t>(n_strips()) + 1, 0);
  for_each_strip([&](std::uint32_t, std::size_t strip) { ++first_[strip + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  triangles_.resize(first_.back());
  std::vector<std::size_t> next = first_;
  for_each_strip([&](std::uint32_t t, std::size_t strip) { triangles_[next[strip]++] = t; });
}

void TinRaster::find_rounding() {
  if (tin_.heights.empty()) return;
  const auto [lower, upper] = std::minmax_element(tin_.heights.begin(), tin_.heights.end());
  // Rises, at most the range, with half a unit each, of products, their sum and quotient as much;
  // then one of the height. What underflows is less than a few of the least.
  rounding_ = 0x1p-53 * (5 * (*upper - *lower) + std::max(std::abs(*lower), std::abs(*upper))) +
              8 * std::numeric_limits<double>::denorm_min();
  // Level planes are exact.
  if (*lower == *upper) rounding_ = 0;
  // Sums of weights below 2^33 and rises below 2^20 are exact then, so that quotient and height are
  // rounded correctly; and that never passes a number which floats hold.
  constexpr double kSmall = 0x1p19;
  keeps_whole_numbers_ =
      *lower >= -kSmall && *upper <= kSmall &&
      std::ranges::all_of(tin_.heights, [](double z) { return z == std::floor(z); });
}

void TinRaster::fill_triangle(std::uint32_t triangle, std::int32_t strip,
                              std::span<double> heights) const {
  std::array<LatticePoint, 3> at;
  std::array<double, 3> z{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t vertex = tin_.triangles[triangle][i];
    at[i] = tin_.vertices[vertex];
    z[i] = tin_.heights[vertex];
  }
  const PlaneRow plane(at, z);
  const std::int32_t first = first_row(strip);
  const std::int32_t end = first + n_rows(strip);
  delaunay::TriangleRows rows(at[0], at[1], at[2]);
  for (rows.skip_to(first); rows.has_row() && rows.y() < end; rows.next())
    plane.fill(rows.y(), rows.first(), rows.last(),
               heights.data() + std::int64_t{rows.y() - first} * n_columns_ + rows.first());
}

void TinRaster::fill(std::int32_t strip, std::span<double> heights) const {
  LODE_EXPECTS(heights.size() == n_nodes(strip));
  std::fill(heights.begin(), heights.end(), std::numeric_limits<double>::quiet_NaN());
  const auto s = static_cast<std::size_t>(strip);
  for (std::size_t i = first_[s]; i < first_[s + 1]; ++i)
    fill_triangle(triangles_[i], strip, heights);
  const std::int32_t first = first_row(strip);
  const auto below = [](LatticePoint p, std::int32_t y) { return p.y < y; };
  const auto begin = std::lower_bound(tin_.vertices.begin(), tin_.vertices.end(), first, below);
  const auto end = std::lower_bound(begin, tin_.vertices.end(), first + n_rows(strip), below);
  for (auto p = begin; p != end; ++p)
    heights[static_cast<std::size_t>(std::int64_t{p->y - first} * n_columns_ + p->x)] =
        tin_.heights[static_cast<std::size_t>(p - tin_.vertices.begin())];
}

}  // namespace lode
