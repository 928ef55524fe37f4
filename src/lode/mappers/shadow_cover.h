#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/collapse_cover.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_pieces.h"

namespace lode::simplification {

/// Whether the shadows of original triangles on a new triangle's plane cover it. A point of a
/// shadow is as far from the original as its height there, which is linear in each triangle, so no
/// farther than at a corner. Modulo 2, how many shadows a point of the plane lies in changes only
/// at shadows of edges that an odd number of the triangles has. From one triangle on, neighbours
/// are taken in across all edges whose shadows meet the new triangle; then no such edge does, and
/// where one point of the new triangle lies in an odd number of shadows, all lie in some. Where the
/// original ends, or three of its triangles have an edge, nothing is proven.
class ShadowCover {
  /// Numbers in a table that grows with them.
  class Set {
   public:
    void clear();
    /// Whether it was not there.
    bool insert(std::uint32_t number);

   private:
    static constexpr std::size_t kLeast = 64;
    static constexpr std::size_t kLarge = 4096;

    std::vector<std::uint32_t> table_ = std::vector<std::uint32_t>(kLeast, kNone);
    std::size_t n_ = 0;
  };

 public:
  ShadowCover(const Surface& original, const Surroundings& around, double limit);

  /// A squared distance that no point of the triangle exceeds; kUnproven if it is not covered from
  /// `start`, an original vertex, within the limit, or that is not clear.
  [[nodiscard]] double bound(const Piece& triangle, std::uint32_t start);

 private:
  /// An original vertex over the new triangle's plane.
  struct Shadow {
    double x = 0, y = 0;
    double height = 0;               ///< Over the plane; below it negative.
    std::array<double, 3> inside{};  ///< Of the line of each edge: distance, outside negative.
  };
  /// A triangle to be entered across its edge from v to w.
  struct Entry {
    std::uint32_t triangle;
    std::uint32_t v, w;
    Shadow at_v, at_w;
  };

  [[nodiscard]] bool place(const Piece& triangle);
  [[nodiscard]] Shadow shadow_of(std::uint32_t vertex) const;
  [[nodiscard]] bool is_low(const std::array<const Shadow*, 3>& corners);
  [[nodiscard]] double height_inside(const std::array<const Shadow*, 3>& corners) const;
  [[nodiscard]] bool start_at(std::uint32_t vertex);
  [[nodiscard]] bool take(const Entry& entry);
  [[nodiscard]] bool go_across(std::uint32_t triangle, std::uint32_t v, std::uint32_t w,
                               const Shadow& at_v, const Shadow& at_w);
  [[nodiscard]] bool misses(const Shadow& a, const Shadow& b) const;
  [[nodiscard]] bool count(const std::array<const Shadow*, 3>& corners);

  static constexpr double kMargin = 1e-7;  ///< Of distances in the plane, in limits.
  /// Edges and what else is in the plane, at most, in limits.
  static constexpr double kLargest = 1e5;

  const Surface& original_;
  Surroundings around_;
  double limit_;
  double margin_;
  Vec3d origin_, right_, forward_, up_;
  std::array<std::array<double, 2>, 3> corners_{};  ///< Of the new triangle, in its plane.
  std::array<std::array<double, 2>, 3> inward_{};   ///< Unit normals of its edges there.
  std::array<double, 2> middle_{};                  ///< A point inside.
  double highest_ = 0;
  bool is_odd_ = false;
  std::vector<Entry> pending_;
  Set met_;  ///< Original triangles.
};

}  // namespace lode::simplification
