#include "lode/delaunay/full_tin.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace lode::delaunay {
namespace {

/// Fills a TIN row by row, each cell's triangles linked with those to its left and below it.
class FullTinMaker {
 public:
  explicit FullTinMaker(const HeightGrid& grid) : grid_(grid) {
    for (auto* row : {&lower_, &upper_}) row->assign(static_cast<std::size_t>(grid.n_columns), 0);
    tops_.assign(static_cast<std::size_t>(grid.n_columns), kNoHalfEdge);
  }

  Result<FullTin> run() {
    for (std::int32_t y = 0; y < grid_.n_rows; ++y) {
      number_row(y);
      if (y > 0) add_cells(y - 1);
      if (made_.tin.triangles.size() > kMostTriangles)
        return fail("expected up to {} triangles, got more: a larger tolerance takes fewer",
                    kMostTriangles);
    }
    if (made_.tin.triangles.empty())
      return fail(
          "expected at least one cell with heights at its four corners, got none ({} of {} samples "
          "are missing)",
          grid_.n_missing(), grid_.n_samples());
    made_.tin.errors.assign(made_.tin.triangles.size(), 0);
    return std::move(made_);
  }

 private:
  [[nodiscard]] bool has_cell(std::int32_t x, std::int32_t y) const {
    return x >= 0 && y >= 0 && x + 1 < grid_.n_columns && y + 1 < grid_.n_rows &&
           grid_.has_height(x, y) && grid_.has_height(x + 1, y) && grid_.has_height(x, y + 1) &&
           grid_.has_height(x + 1, y + 1);
  }
  /// Numbers the vertices of a row, and moves that below it down.
  void number_row(std::int32_t y) {
    std::swap(lower_, upper_);
    for (std::int32_t x = 0; x < grid_.n_columns; ++x) {
      if (!grid_.has_height(x, y)) continue;
      if (!has_cell(x, y) && !has_cell(x - 1, y) && !has_cell(x, y - 1) &&
          !has_cell(x - 1, y - 1)) {
        ++made_.n_left_out;
        continue;
      }
      upper_[static_cast<std::size_t>(x)] = static_cast<std::uint32_t>(made_.tin.vertices.size());
      made_.tin.vertices.push_back({x, y});
      made_.tin.heights.push_back(grid_.height(x, y));
    }
  }
  void add_cells(std::int32_t y) {
    std::uint32_t left = kNoHalfEdge;  // The right side of the cell before.
    for (std::int32_t x = 0; x + 1 < grid_.n_columns; ++x) {
      const auto column = static_cast<std::size_t>(x);
      if (has_cell(x, y)) {
        left = add_cell(column, left);
      } else {
        left = tops_[column] = kNoHalfEdge;
      }
    }
  }
  /// Returns the right side's edge.
  std::uint32_t add_cell(std::size_t x, std::uint32_t left) {
    Tin& tin = made_.tin;
    const std::uint32_t a = lower_[x];
    const std::uint32_t b = lower_[x + 1];
    const std::uint32_t c = upper_[x + 1];
    const std::uint32_t d = upper_[x];
    const auto first = static_cast<std::uint32_t>(4 * tin.triangles.size());
    const std::uint32_t second = first + 4;
    const std::uint32_t below = tops_[x];
    constexpr std::uint32_t kOpen = kNoHalfEdge;
    const bool is_rising =
        std::abs(tin.heights[a] - tin.heights[c]) <= std::abs(tin.heights[b] - tin.heights[d]);
    if (is_rising) {
      tin.triangles.push_back({a, b, c});
      tin.triangles.push_back({a, c, d});
      tin.twins.push_back({below, kOpen, second});
      tin.twins.push_back({first + 2, kOpen, left});
    } else {
      tin.triangles.push_back({a, b, d});
      tin.triangles.push_back({b, c, d});
      tin.twins.push_back({below, second + 2, left});
      tin.twins.push_back({kOpen, kOpen, first + 1});
    }
    link(below, first);
    link(left, is_rising ? second + 2 : first + 2);
    tops_[x] = second + 1;
    return is_rising ? first + 1 : second;
  }
  void link(std::uint32_t half_edge, std::uint32_t twin) {
    if (half_edge != kNoHalfEdge) made_.tin.twins[half_edge / 4][half_edge % 4] = twin;
  }

  const HeightGrid& grid_;
  std::vector<std::uint32_t> lower_;  ///< Numbers of vertices of the row below the cells.
  std::vector<std::uint32_t> upper_;
  std::vector<std::uint32_t> tops_;  ///< Per column: the upper side of the cell below.
  FullTin made_;
};

}  // namespace

Result<FullTin> to_full_tin(const HeightGrid& grid) {
  if (grid.n_columns < 2 || grid.n_rows < 2)
    return fail("expected at least 2 x 2 samples, got {} x {}, which span no area", grid.n_columns,
                grid.n_rows);
  return FullTinMaker(grid).run();
}

}  // namespace lode::delaunay
