#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "lode/delaunay/predicates.h"

namespace lode {

/// Finds the triangles that hold a place, exactly, of any in the plane, with coordinates in
/// float64: they need not meet, and may overlap. Squares know the triangles that reach into them;
/// those that know many are cut in squares again, where that helps. Const members are safe from
/// many threads. O(n log n) to make, and about 16 bytes a triangle where they are about alike.
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
    for (const std::uint32_t triangle : triangles_near(p))
      if (holds(triangle, p)) visit(triangle);
  }
  /// Those that are looked at for p, which is in the rectangle of all.
  [[nodiscard]] std::span<const std::uint32_t> triangles_near(const delaunay::Point& p) const;

 private:
  /// A rectangle's squares.
  struct Squares {
    delaunay::Point lower{};
    double per_unit = 1;  ///< Squares.
    std::size_t n_columns = 1;
    std::size_t n_rows = 1;
    std::vector<std::uint64_t> first{};    ///< Per square, and one more: where its list begins.
    std::vector<std::uint32_t> entries{};  ///< Triangles.
    std::unordered_map<std::size_t, Squares> finer{};  ///< By square: of those that know many.

    [[nodiscard]] std::size_t square_of(const delaunay::Point& p) const;
  };

  [[nodiscard]] bool is_in_rectangle(const delaunay::Point& p) const {
    return p[0] >= lower_[0] && p[0] <= upper_[0] && p[1] >= lower_[1] && p[1] <= upper_[1];
  }
  /// Of a rectangle and triangles that may reach into it; none where they would be in too many
  /// squares. `depth`: of squares around it.
  [[nodiscard]] std::optional<Squares> squares_of(const delaunay::Point& lower,
                                                  const delaunay::Point& upper,
                                                  std::span<const std::uint32_t> triangles,
                                                  int depth) const;
  void cut_crowded(Squares& squares, int depth) const;
  template <typename Visit>
  void visit_squares(const Squares& squares, std::uint32_t triangle, const Visit& visit) const;

  std::span<const delaunay::Point> vertices_;
  std::span<const Triangle> triangles_;
  delaunay::Point lower_{};  ///< Of all corners.
  delaunay::Point upper_{};
  Squares squares_;
};

}  // namespace lode
