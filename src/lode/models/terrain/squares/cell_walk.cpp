#include "lode/models/terrain/squares/cell_walk.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace lode::squares {
namespace {

using delaunay::Point;

/// Along one axis: which column (or row) of cells a segment is in, and where it enters the next.
class AxisWalk {
 public:
  AxisWalk(double from, double to, std::int32_t n_cells)
      : from_(from), way_(to - from), to_(to), n_cells_(n_cells) {
    const double first = way_ < 0 ? std::ceil(from) - 1 : std::floor(from);
    // Beyond the raster, and so is the one before it.
    cell_ = static_cast<std::int32_t>(std::clamp(first, -1.0, n_cells + 1.0));
    next_ = std::clamp(way_ < 0 ? first : first + 1, 0.0, static_cast<double>(n_cells));
  }
  [[nodiscard]] bool has_next() const {
    if (way_ > 0) return next_ <= n_cells_ && next_ < to_ && next_ > from_;
    return way_ < 0 && next_ >= 0 && next_ > to_ && next_ < from_;
  }
  /// Beyond the end where there is none.
  [[nodiscard]] double t() const { return has_next() ? (next_ - from_) / way_ : 2; }
  void take() {
    cell_ = static_cast<std::int32_t>(way_ > 0 ? next_ : next_ - 1);
    next_ += way_ > 0 ? 1 : -1;
  }
  [[nodiscard]] std::int32_t cell() const { return cell_; }
  /// It stays on the side between two.
  [[nodiscard]] bool is_on_side() const { return way_ == 0 && from_ == std::floor(from_); }

 private:
  double from_;
  double way_;
  double to_;
  double next_;
  std::int32_t n_cells_;
  std::int32_t cell_;
};

/// What is in a cell, or between two of them.
class StepMaker {
 public:
  StepMaker(const CellGrid& grid, const Point& a, const Point& b,
            const std::function<void(const WalkStep&)>& visit)
      : grid_(grid), a_(a), b_(b), visit_(visit) {}

  void between(double begin, double end, const AxisWalk& columns, const AxisWalk& rows) const {
    if (!(end > begin)) return;
    const std::int32_t x = columns.cell();
    const std::int32_t y = rows.cell();
    if (columns.is_on_side()) return emit(begin, end, {{x - 1, y, false}, {x, y, true}});
    if (rows.is_on_side()) return emit(begin, end, {{x, y - 1, true}, {x, y, false}});
    if (grid_.has(x, y)) in_cell(begin, end, x, y);
  }

 private:
  void in_cell(double begin, double end, std::int32_t x, std::int32_t y) const {
    const CellHalf lower{x, y, false};
    const CellHalf upper{x, y, true};
    // Beside the diagonal: positive in the lower half.
    const double first = (a_[0] - x) - (a_[1] - y);
    const double last = (b_[0] - x) - (b_[1] - y);
    if (first == 0 && last == 0) return emit(begin, end, {lower, upper});
    if (first >= 0 && last >= 0) return emit(begin, end, {lower});
    if (first <= 0 && last <= 0) return emit(begin, end, {upper});
    const double middle = std::clamp(first / (first - last), begin, end);
    emit(begin, middle, {first > 0 ? lower : upper});
    emit(middle, end, {first > 0 ? upper : lower});
  }
  void emit(double begin, double end, std::initializer_list<CellHalf> halves) const {
    if (!(end > begin)) return;
    WalkStep step{begin, end, {}};
    for (const CellHalf& half : halves)
      if (grid_.has(half.x, half.y)) step.halves.add(half);
    if (!step.halves.get().empty()) visit_(step);
  }

  const CellGrid& grid_;
  const Point& a_;
  const Point& b_;
  const std::function<void(const WalkStep&)>& visit_;
};

}  // namespace

CellHalves halves_at(const CellGrid& grid, const Point& p) {
  CellHalves halves;
  if (!(p[0] >= 0 && p[1] >= 0 && p[0] <= grid.n_columns && p[1] <= grid.n_rows)) return halves;
  const auto x = static_cast<std::int32_t>(p[0]);
  const auto y = static_cast<std::int32_t>(p[1]);
  const std::int32_t before_x = p[0] == x ? x - 1 : x;
  const std::int32_t before_y = p[1] == y ? y - 1 : y;
  for (std::int32_t row = before_y; row <= y; ++row)
    for (std::int32_t column = before_x; column <= x; ++column) {
      if (!grid.has(column, row)) continue;
      // Differences from whole numbers below are exact.
      const double u = p[0] - column;
      const double v = p[1] - row;
      if (u >= v) halves.add({column, row, false});
      if (u <= v) halves.add({column, row, true});
    }
  return halves;
}

void walk_cells(const CellGrid& grid, const Point& a, const Point& b,
                const std::function<void(const WalkStep&)>& visit) {
  AxisWalk columns(a[0], b[0], grid.n_columns);
  AxisWalk rows(a[1], b[1], grid.n_rows);
  const StepMaker steps(grid, a, b, visit);
  double begin = 0;
  while (columns.has_next() || rows.has_next()) {
    AxisWalk& first = columns.t() <= rows.t() ? columns : rows;
    const double end = std::clamp(first.t(), begin, 1.0);
    steps.between(begin, end, columns, rows);
    first.take();
    begin = end;
  }
  steps.between(begin, 1, columns, rows);
}

}  // namespace lode::squares
