#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_pieces.h"

namespace lode::simplification {

/// What of a new triangle the shadows of original ones on its plane cover. A point of a shadow is
/// as far from the original as its height there, which is linear in each triangle, so no farther
/// than at a corner. Modulo 2, how many shadows a point of the plane lies in changes only at
/// shadows of edges that an odd number of the triangles has. From those round a vertex on,
/// neighbours that are within the limit over the new triangle are taken in across all edges whose
/// shadows meet it. What is left of such edges are *rims*: where the original ends or is too high,
/// and edges of three of its triangles. Without any, where one point of the new triangle lies in an
/// odd number of shadows, all lie in some; else that holds for each part that no rim meets.
class ShadowCover {
  /// Numbers in a table that grows with them.
  class Set {
   public:
    void clear();
    /// Whether it was not there.
    bool insert(std::uint32_t number);
    [[nodiscard]] bool contains(std::uint32_t number) const {
      return n_ > 0 && table_[place(number)] == number;
    }

   private:
    /// Where it is, or would be.
    [[nodiscard]] std::size_t place(std::uint32_t number) const;

    static constexpr std::size_t kLeast = 64;
    static constexpr std::size_t kLarge = 4096;

    std::vector<std::uint32_t> table_ = std::vector<std::uint32_t>(kLeast, kNone);
    std::size_t n_ = 0;
  };

 public:
  ShadowCover(const Surface& original, const Surroundings& around, double limit);

  /// Forgets all, for another triangle. A squared distance that no point of it exceeds; kUnproven
  /// if not all of it is covered from `start`, an original vertex, within the limit, or that is not
  /// clear.
  [[nodiscard]] double bound(const Piece& triangle, std::uint32_t start);
  /// The same, with the shadows that are there and those from another start.
  [[nodiscard]] double bound_with(std::uint32_t start);

  /// Whether there are rims: then parts may be covered.
  [[nodiscard]] bool has_rims() const { return !rims_.empty(); }
  static constexpr std::size_t kMostCells = 64;
  /// Sets is_covered[i] where cell i of n * n of a piece of the triangle (cell_of()), at most
  /// kMostCells, is covered, else leaves it. `radius`: of a cell round its middle, at least.
  void mark_covered(const Piece& piece, std::size_t n, double radius,
                    std::span<std::int32_t> is_covered) const;

 private:
  /// An original vertex over the new triangle's plane.
  struct Shadow {
    double x = 0, y = 0;
    double height = 0;               ///< Over the plane; below it negative.
    std::array<double, 3> inside{};  ///< Of the line of each edge: distance, outside negative.
  };
  /// A triangle and its corners.
  struct Cast {
    std::uint32_t triangle;
    std::array<std::uint32_t, 3> v;
    std::array<Shadow, 3> at;
    bool is_entered;  ///< Across the edge from v[0] to v[1].
  };
  using Point = std::array<double, 2>;
  enum class Holds : std::uint8_t { no, yes, blurred };
  using Rim = std::array<Point, 2>;
  /// Of a cell among those of a piece: upside down where k is 1.
  struct Place {
    int row, column, k;

    [[nodiscard]] static Place of(std::size_t cell);
    [[nodiscard]] std::size_t cell() const {
      const auto r = static_cast<std::size_t>(row);
      return r * r + 2 * static_cast<std::size_t>(column) + static_cast<std::size_t>(k);
    }
  };
  /// The cells of a piece in the plane.
  class Lattice {
   public:
    /// Its first corner, and from there to the second and on to the third.
    Lattice(const Point& origin, const Point& along_rows, const Point& along_columns,
            std::size_t n);
    [[nodiscard]] Point middle(const Place& at) const;
    template <typename Visit>
    void for_each_near(const Rim& rim, double reach, const Visit& visit) const;
    template <typename Visit>
    void for_each_beside(const Place& at, const Visit& visit) const;

   private:
    Point origin_, row_, column_;
    Point to_row_, to_column_;  ///< Of a point from the origin.
    Point slack_;               ///< Rows and columns that a distance in the plane may be.
    int n_;
  };

  [[nodiscard]] Point in_plane(const Vec3d& point) const {
    const Vec3d d = point - origin_;
    return {dot(d, right_), dot(d, forward_)};
  }
  [[nodiscard]] bool place(const Piece& triangle);
  [[nodiscard]] Shadow shadow_of(std::uint32_t vertex) const;
  [[nodiscard]] bool is_low(const std::array<Shadow, 3>& corners);
  [[nodiscard]] double height_inside(const std::array<Shadow, 3>& corners) const;
  void start_at(std::uint32_t vertex);
  [[nodiscard]] bool take(const Cast& cast);
  void go_across(const Cast& cast, std::size_t i, std::size_t j);
  [[nodiscard]] std::uint32_t beyond(std::uint32_t triangle, std::uint32_t v,
                                     std::uint32_t w) const;
  [[nodiscard]] bool misses(const Shadow& a, const Shadow& b) const;
  [[nodiscard]] Holds held_by(const std::array<Point, 3>& shadow, const Point& p) const;
  [[nodiscard]] Holds held_by_odd(const Point& p) const;
  [[nodiscard]] static double squared_distance_to(const Rim& rim, const Point& p);

  static constexpr double kMargin = 1e-7;  ///< Of distances in the plane, in limits.
  /// Edges and what else is in the plane, at most, in limits.
  static constexpr double kLargest = 1e5;

  const Surface& original_;
  Surroundings around_;
  double limit_;
  double margin_;
  Vec3d origin_, right_, forward_, up_;
  std::array<Point, 3> corners_{};  ///< Of the new triangle, in its plane.
  std::array<Point, 3> inward_{};   ///< Unit normals of its edges there.
  Point middle_{};                  ///< A point inside.
  double highest_ = 0;
  bool is_placed_ = false;
  bool is_odd_ = false;      ///< Shadows that the middle lies in,
  bool is_blurred_ = false;  ///< if that is clear.
  std::vector<Cast> pending_;
  std::vector<std::array<Point, 3>> shadows_;
  std::vector<Rim> rims_;
  Set met_;   ///< Original triangles,
  Set high_;  ///< and those of them that are not taken.
};

}  // namespace lode::simplification
