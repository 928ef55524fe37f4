#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/delaunay/predicates.h"

namespace lode {

/// Finds the triangles that hold a place, exactly, of any in the plane, with coordinates in
/// float64: they need not meet, and may overlap. Squares know the triangles that reach into them.
/// Const members are safe from many threads. O(n) to make where triangles are about alike, and
/// about 16 bytes a triangle.
class PlaneLocator {
 public:
  using Triangle = std::array<std::uint32_t, 3>;

  /// Triangles turn left, one at least, with finite corners. Both outlive it.
  PlaneLocator(std::span<const delaunay::Point> vertices, std::span<const Triangle> triangles);

  /// Whether the closed triangle holds p, exactly.
  [[nodiscard]] bool holds(std::uint32_t triangle, const delaunay::Point& p) const;

  /// Calls visit(triangle) for each that holds p, which is finite, in their order.
  template <typename Visit>
  void visit(const delaunay::Point& p, const Visit& visit) const {
    if (!is_in_rectangle(p)) return;
    const std::size_t square = static_cast<std::size_t>(row_of(p[1])) * n_columns_ +
                               static_cast<std::size_t>(column_of(p[0]));
    for (std::uint64_t i = first_[square]; i < first_[square + 1]; ++i)
      if (holds(entries_[i], p)) visit(entries_[i]);
  }

 private:
  [[nodiscard]] bool is_in_rectangle(const delaunay::Point& p) const {
    return p[0] >= lower_[0] && p[0] <= upper_[0] && p[1] >= lower_[1] && p[1] <= upper_[1];
  }
  [[nodiscard]] std::int64_t column_of(double x) const;
  [[nodiscard]] std::int64_t row_of(double y) const;
  void choose_size();
  void fill_squares();
  template <typename Visit>
  void visit_squares(std::uint32_t triangle, const Visit& visit) const;

  std::span<const delaunay::Point> vertices_;
  std::span<const Triangle> triangles_;
  delaunay::Point lower_{};  ///< Of all corners.
  delaunay::Point upper_{};
  double per_unit_ = 1;  ///< Squares.
  std::size_t n_columns_ = 1;
  std::size_t n_rows_ = 1;
  std::vector<std::uint64_t> first_;    ///< Per square, and one more: where its list begins.
  std::vector<std::uint32_t> entries_;  ///< Triangles.
};

}  // namespace lode
