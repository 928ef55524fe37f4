// Which cells of a triangle, or of a piece of it, shadows cover where there are rims.
#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/mappers/shadow_cover.h"

namespace lode::simplification {

ShadowCover::Lattice::Lattice(const Point& origin, const Point& along_rows,
                              const Point& along_columns, std::size_t n)
    : origin_(origin), n_(static_cast<int>(n)) {
  const double over = 1 / static_cast<double>(n);
  for (std::size_t i = 0; i < 2; ++i) {
    row_[i] = along_rows[i] * over;
    column_[i] = along_columns[i] * over;
  }
  const double over_area = 1 / (row_[0] * column_[1] - row_[1] * column_[0]);
  to_row_ = {column_[1] * over_area, -column_[0] * over_area};
  to_column_ = {-row_[1] * over_area, row_[0] * over_area};
  slack_ = {std::hypot(to_row_[0], to_row_[1]), std::hypot(to_column_[0], to_column_[1])};
}

ShadowCover::Place ShadowCover::Place::of(std::size_t cell) {
  std::size_t row = 0;
  while ((row + 1) * (row + 1) <= cell) ++row;
  const std::size_t at = cell - row * row;
  return {static_cast<int>(row), static_cast<int>(at / 2), static_cast<int>(at % 2)};
}

ShadowCover::Point ShadowCover::Lattice::middle(const Place& at) const {
  const double r = at.row + (2 - at.k) / 3.0;
  const double c = at.column + (1 + at.k) / 3.0;
  return {origin_[0] + r * row_[0] + c * column_[0], origin_[1] + r * row_[1] + c * column_[1]};
}

/// Calls visit(place) for cells whose middle may lie within reach of the box of a rim, as rows and
/// columns see it.
template <typename Visit>
void ShadowCover::Lattice::for_each_near(const Rim& rim, double reach, const Visit& visit) const {
  std::array<double, 2> low{kUnproven, kUnproven};
  std::array<double, 2> high{-kUnproven, -kUnproven};
  for (const Point& p : rim) {
    const Point d{p[0] - origin_[0], p[1] - origin_[1]};
    const Point at{to_row_[0] * d[0] + to_row_[1] * d[1],
                   to_column_[0] * d[0] + to_column_[1] * d[1]};
    for (std::size_t i = 0; i < 2; ++i) {
      low[i] = std::min(low[i], at[i]);
      high[i] = std::max(high[i], at[i]);
    }
  }
  // Middles are a third or two thirds beyond whole numbers; rounding takes far less than a sixth.
  const auto size = static_cast<double>(n_);
  std::array<int, 2> first{};
  std::array<int, 2> last{};
  for (std::size_t i = 0; i < 2; ++i) {
    const double slack = reach * slack_[i];
    first[i] = static_cast<int>(std::clamp(low[i] - slack + 1.0 / 6, 0.0, size));
    last[i] = static_cast<int>(std::clamp(high[i] + slack + 5.0 / 6, 0.0, size)) - 1;
  }
  for (int row = first[0]; row <= last[0]; ++row)
    for (int column = first[1]; column <= std::min(row, last[1]); ++column)
      for (int k = 0; k < (column < row ? 2 : 1); ++k) visit(Place{row, column, k});
}

/// Those across the edges of a cell.
template <typename Visit>
void ShadowCover::Lattice::for_each_beside(const Place& at, const Visit& visit) const {
  const auto [row, column, k] = at;
  if (k == 1) {
    visit(Place{row, column, 0});
    visit(Place{row, column + 1, 0});
    visit(Place{row - 1, column, 0});
    return;
  }
  if (column < row) visit(Place{row, column, 1});
  if (column > 0) visit(Place{row, column - 1, 1});
  if (row + 1 < n_) visit(Place{row + 1, column, 1});
}

/// Cells that no rim meets and that have an edge in common lie in as many shadows, modulo 2.
void ShadowCover::mark_covered(const Piece& piece, std::size_t n, double radius,
                               std::span<std::int32_t> is_covered) const {
  const Point a = in_plane(piece[0]);
  const Point b = in_plane(piece[1]);
  const Point c = in_plane(piece[2]);
  const Lattice lattice(a, {b[0] - a[0], b[1] - a[1]}, {c[0] - b[0], c[1] - b[1]}, n);
  std::array<bool, kMostCells> is_left_out{};  // met, or seen
  const double reach = radius + margin_;
  for (const Rim& rim : rims_)
    lattice.for_each_near(rim, reach, [&](const Place& at) {
      if (squared_distance_to(rim, lattice.middle(at)) <= reach * reach)
        is_left_out[at.cell()] = true;
    });
  std::array<Place, kMostCells> pending;
  for (std::size_t cell = 0; cell < n * n; ++cell) {
    if (is_left_out[cell]) continue;
    const Place first = Place::of(cell);
    is_left_out[cell] = true;
    const Holds holds = held_by_odd(lattice.middle(first));
    if (holds == Holds::blurred) continue;
    std::size_t n_pending = 0;
    pending[n_pending++] = first;
    while (n_pending > 0) {
      const Place at = pending[--n_pending];
      if (holds == Holds::yes) is_covered[at.cell()] = 1;
      lattice.for_each_beside(at, [&](const Place& next) {
        if (is_left_out[next.cell()]) return;
        is_left_out[next.cell()] = true;
        pending[n_pending++] = next;
      });
    }
  }
}

/// Whether a point lies in an odd number of shadows.
ShadowCover::Holds ShadowCover::held_by_odd(const Point& p) const {
  bool is_odd = false;
  for (const auto& shadow : shadows_) {
    const Holds holds = held_by(shadow, p);
    if (holds == Holds::blurred) return holds;
    is_odd = is_odd != (holds == Holds::yes);
  }
  return is_odd ? Holds::yes : Holds::no;
}

double ShadowCover::squared_distance_to(const Rim& rim, const Point& p) {
  const double dx = rim[1][0] - rim[0][0];
  const double dy = rim[1][1] - rim[0][1];
  const double px = p[0] - rim[0][0];
  const double py = p[1] - rim[0][1];
  const double length2 = std::max(dx * dx + dy * dy, std::numeric_limits<double>::min());
  const double along = std::clamp((px * dx + py * dy) / length2, 0.0, 1.0);
  const double qx = px - along * dx;
  const double qy = py - along * dy;
  return qx * qx + qy * qy;
}

}  // namespace lode::simplification
