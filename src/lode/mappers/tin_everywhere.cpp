#include "lode/mappers/tin_everywhere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lode/core/expects.h"
#include "lode/delaunay/triangle_error.h"

namespace lode {
namespace {

/// A place in columns and rows, with a height.
struct Station {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// The surface of all samples, and how far edges are from it where they cross its edges.
class FullSurface {
 public:
  explicit FullSurface(const HeightGrid& grid) : grid_(grid) {}

  /// The largest distance of the edge where it crosses columns, rows and diagonals of cells.
  [[nodiscard]] double largest_off(const Station& a, const Station& b) const {
    double largest = 0;
    double last = 0;
    const auto stop = [&](double t) {
      if (t > last) largest = std::max(largest, off_between(a, b, last, t));
      last = std::max(last, t);
    };
    // Both kinds of crossings, in the order along the edge.
    Crossings columns(a.x, b.x);
    Crossings rows(a.y, b.y);
    while (columns.has_next() || rows.has_next())
      stop(columns.t() <= rows.t() ? columns.take() : rows.take());
    stop(1);
    return largest;
  }

 private:
  /// Where a coordinate is a whole number strictly between two ends: as shares of the way.
  class Crossings {
   public:
    Crossings(double from, double to) : from_(from), way_(to - from) {
      next_ = way_ > 0 ? std::floor(from) + 1 : std::ceil(from) - 1;
      to_ = to;
    }
    [[nodiscard]] bool has_next() const { return way_ > 0 ? next_ < to_ : way_ < 0 && next_ > to_; }
    /// Beyond the end where there is none.
    [[nodiscard]] double t() const { return has_next() ? (next_ - from_) / way_ : 2; }
    double take() {
      const double at = t();
      next_ += way_ > 0 ? 1 : -1;
      return at;
    }

   private:
    double from_;
    double way_;
    double to_ = 0;
    double next_ = 0;
  };

  static Station on_edge(const Station& a, const Station& b, double t) {
    return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
  }

  /// Of a part of the edge in one cell, or along its side: at its end, and where it crosses the
  /// diagonal.
  [[nodiscard]] double off_between(const Station& a, const Station& b, double from,
                                   double to) const {
    const Station middle = on_edge(a, b, (from + to) / 2);
    const Cell cell(grid_, middle);
    // So short that rounding has put it beside the domain: its ends are those of others.
    if (!cell.is_there()) return 0;
    const Station end = on_edge(a, b, to);
    double off = std::abs(cell.height(end) - end.z);
    const Station begin = on_edge(a, b, from);
    const double before = cell.beside_diagonal(begin);
    const double after = cell.beside_diagonal(end);
    if ((before > 0) != (after > 0) && before != after) {
      const double share = before / (before - after);
      const Station at = on_edge(a, b, from + (to - from) * std::clamp(share, 0.0, 1.0));
      off = std::max(off, std::abs(cell.height(at) - at.z));
    }
    return off;
  }

  /// A cell with four heights: that which holds a place, or, on a column or row, one beside it.
  class Cell {
   public:
    Cell(const HeightGrid& grid, const Station& at)
        : x_(column_of(grid, at)), y_(row_of(grid, at)) {
      if (!has_heights(grid, x_, y_) && at.y == y_) --y_;
      if (!has_heights(grid, x_, y_) && at.x == x_) --x_;
      is_there_ = has_heights(grid, x_, y_);
      if (!is_there_) return;
      for (std::int32_t i = 0; i < 4; ++i)
        z_[static_cast<std::size_t>(i)] = grid.height(x_ + i % 2, y_ + i / 2);
      is_rising_ = std::abs(z_[0] - z_[3]) <= std::abs(z_[1] - z_[2]);
    }
    [[nodiscard]] bool is_there() const { return is_there_; }
    /// On its two triangles.
    [[nodiscard]] double height(const Station& at) const {
      const double u = at.x - x_;
      const double v = at.y - y_;
      const auto [a, b, d, c] = z_;
      if (is_rising_) return u >= v ? a + u * (b - a) + v * (c - b) : a + v * (d - a) + u * (c - d);
      return u + v <= 1 ? a + u * (b - a) + v * (d - a) : c + (1 - u) * (d - c) + (1 - v) * (b - c);
    }
    /// Of two sides of the diagonal positive on one.
    [[nodiscard]] double beside_diagonal(const Station& at) const {
      const double u = at.x - x_;
      const double v = at.y - y_;
      return is_rising_ ? u - v : 1 - u - v;
    }

   private:
    static std::int32_t column_of(const HeightGrid& grid, const Station& at) {
      return std::clamp(static_cast<std::int32_t>(std::floor(at.x)), 0, grid.n_columns - 2);
    }
    static std::int32_t row_of(const HeightGrid& grid, const Station& at) {
      return std::clamp(static_cast<std::int32_t>(std::floor(at.y)), 0, grid.n_rows - 2);
    }
    static bool has_heights(const HeightGrid& grid, std::int32_t x, std::int32_t y) {
      return x >= 0 && y >= 0 && grid.has_height(x, y) && grid.has_height(x + 1, y) &&
             grid.has_height(x, y + 1) && grid.has_height(x + 1, y + 1);
    }

    std::int32_t x_;
    std::int32_t y_;
    std::array<double, 4> z_{};  ///< Lower left, lower right, upper left, upper right.
    bool is_there_ = false;
    bool is_rising_ = false;  ///< The diagonal from the lower left.
  };

  const HeightGrid& grid_;
};

/// What rounding may do, in the unit of heights: places are off by a few units in the last place of
/// the largest column or row, and in a step heights change by no more than their range.
double rounding_of(const HeightGrid& grid) {
  const HeightRange range = height_range(grid);
  const double largest = std::max(std::abs(range.lower), std::abs(range.upper));
  const double side = std::max(grid.n_columns, grid.n_rows);
  return 0x1p-49 * (side * (range.upper - range.lower) + 16 * largest);
}

}  // namespace

Result<void> raise_errors_everywhere(const HeightGrid& grid, std::int32_t scale, Threads threads,
                                     Progress& progress, delaunay::Tin& tin) {
  LODE_EXPECTS(tin.errors.size() == tin.triangles.size());
  LODE_EXPECTS(tin.heights.size() == tin.vertices.size());
  const FullSurface surface(grid);
  const double rounding = rounding_of(grid);
  const auto station = [&](std::uint32_t v) {
    return Station{static_cast<double>(tin.vertices[v].x) / scale,
                   static_cast<double>(tin.vertices[v].y) / scale, tin.heights[v]};
  };
  constexpr std::size_t kGrain = 1024;
  parallel_for(
      (tin.triangles.size() + kGrain - 1) / kGrain, threads, 1, [&](std::size_t part, int) {
        if (progress.is_cancelled()) return;
        const std::size_t end = std::min(tin.triangles.size(), (part + 1) * kGrain);
        for (std::size_t t = part * kGrain; t < end; ++t) {
          double off = 0;
          for (std::size_t i = 0; i < 3; ++i)
            off = std::max(off, surface.largest_off(station(tin.triangles[t][i]),
                                                    station(tin.triangles[t][(i + 1) % 3])));
          if (off > 0)
            tin.errors[t] = std::max(tin.errors[t], delaunay::to_float_above(off + rounding));
        }
      });
  if (progress.is_cancelled()) return cancelled_error();
  return {};
}

}  // namespace lode
