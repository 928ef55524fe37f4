#include "lode/mappers/facet_proof.h"

#include <algorithm>
#include <cmath>

#include "lode/core/point_triangle.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_pieces.h"

namespace lode {
namespace {

using simplification::Piece;

class NearnessProof {
 public:
  NearnessProof(const FacetGrid& others, const NearnessQuery& query)
      : others_(others),
        limit_(query.limit * (1 - 2 * simplification::kRounding)),
        n_left_(query.n_most_pieces) {}

  /// `hint`: a facet that may be near, or kNone.
  bool covers(const Piece& piece, std::uint32_t hint) {
    if (n_left_-- == 0) return false;
    const Vec3d middle = (piece[0] + piece[1] + piece[2]) * (1.0 / 3);
    const double radius = simplification::radius_of(piece);
    // Of several candidates one that is half as far does as well as the nearest, unless many pieces
    // are to be saved.
    const bool is_large = radius > kLarge * limit_;
    const double enough = is_large ? 0 : std::max(limit_ / 2, limit_ - radius);
    const auto found = others_.find(middle, {limit_, enough, hint});
    if (found.facet == kNone) return false;
    const double bound = std::sqrt(found.squared_distance) + radius;
    if (bound <= limit_) return take(found.facet, bound);
    if (const double largest = farthest_corner(piece, found.facet); largest <= limit_)
      return take(found.facet, largest);
    if (radius < kSmallest * limit_ || radius > kLargest * limit_) return false;
    return simplification::for_each_part(
        piece, [&](const Piece& part) { return covers(part, found.facet); });
  }
  [[nodiscard]] double bound() const { return bound_; }
  [[nodiscard]] std::uint32_t witness() const { return n_witnesses_ == 1 ? witness_ : kNone; }

 private:
  // Radii of pieces in units of the limit: smaller ones are not cut, nor are the largest, of which
  // there would be thousands.
  static constexpr double kSmallest = 1.0 / 8;
  static constexpr double kLarge = 4;
  static constexpr double kLargest = 64;
  static constexpr std::uint32_t kNone = FacetGrid::kNone;

  bool take(std::uint32_t facet, double bound) {
    bound_ = std::max(bound_, bound);
    n_witnesses_ += n_witnesses_ == 1 && witness_ == facet ? 0 : 1;
    witness_ = facet;
    return true;
  }
  /// Of the corners, from one facet; may stop beyond the limit.
  [[nodiscard]] double farthest_corner(const Piece& piece, std::uint32_t facet) const {
    const auto target = corners_of(others_.facets()[facet]);
    double largest = 0;
    for (const Vec3d& corner : piece) {
      largest = std::max(largest, squared_distance_to_triangle(corner, target));
      if (largest > limit_ * limit_) break;
    }
    return std::sqrt(largest);
  }

  const FacetGrid& others_;
  double limit_;
  int n_left_;
  double bound_ = 0;
  int n_witnesses_ = 0;
  std::uint32_t witness_ = kNone;
};

}  // namespace

FacetProof prove_near(const Facet& facet, const FacetGrid& others, const NearnessQuery& query) {
  NearnessProof proof(others, query);
  if (!proof.covers(corners_of(facet), query.hint)) return {};
  return {true, proof.bound() * (1 + simplification::kRounding), proof.witness()};
}

}  // namespace lode
