#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <vector>

#include "lode/core/vec.h"
#include "lode/mappers/collapse_pieces.h"

namespace lode::simplification {

/// Squared distance that no point of a triangle exceeds from `targets`, or kUnproven where that is
/// more than `limit2`. Of corner k targets[which[k]] is looked at. Where those of two corners
/// differ, the edge between them is cut at a point within the limit of both, and if all three
/// differ, a point inside is where three pieces meet. So each piece has all its corners near one
/// target, and with them all of it.
[[nodiscard]] double bound_by_cuts(const Piece& triangle, const std::array<Piece, 3>& targets,
                                   const std::array<std::size_t, 3>& which, double limit2);

/// Many triangles that another is to be near. It is cut in two at the middle of an edge again and
/// again, between corners that have none of them near both, until each piece has all its corners
/// near one.
class TriangleCuts {
 public:
  static constexpr std::size_t kMostTargets = 128;

  void begin(const Piece& triangle, double limit);
  /// Beyond kMostTargets they are left out.
  void add(const Piece& target);
  /// Whether no point of the triangle is farther than the limit, as far as that is found out.
  [[nodiscard]] bool covers();

 private:
  struct Corner {
    Vec3d at;
    std::bitset<kMostTargets> near;  ///< Of the targets, those within the limit.
  };
  struct Box {
    Vec3d lower, upper;

    [[nodiscard]] bool holds(const Vec3d& p) const {
      return p[0] >= lower[0] && p[0] <= upper[0] && p[1] >= lower[1] && p[1] <= upper[1] &&
             p[2] >= lower[2] && p[2] <= upper[2];
    }
  };
  /// A target, with what distances from it take.
  struct Target {
    Box around;  ///< No point outside it is near.
    Vec3d origin, u, v;
    double uu, uv, vv;
    double area2;  ///< Squared, four times; negative of a sliver, whose edges are enough.
    double over_uu, over_vv, over_ww, over_area2;
  };

  [[nodiscard]] static Box box_round(const Piece& piece, double reach);
  [[nodiscard]] Corner corner_at(const Vec3d& at) const;
  [[nodiscard]] bool covers_part(const Corner& a, const Corner& b, const Corner& c, int depth);
  Piece triangle_{};
  Box box_;  ///< Round it.
  double limit_ = 0;
  std::vector<Target> targets_;
  int n_corners_ = 0;
};

}  // namespace lode::simplification
