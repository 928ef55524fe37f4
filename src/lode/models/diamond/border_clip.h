#pragma once

#include <array>
#include <span>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Cuts simplices of the hierarchy exactly at the end of the data, the planes x_i = dims_i - 1,
/// into simplices that conform: those of neighbours share whole faces.
///
/// All faces of the hierarchy lie in planes x_i = c or x_i ± x_j = c of integer c, the mirrors of
/// bisection by reflection. So wherever their edges, or the lines in which border planes cut their
/// faces, meet another border plane is a lattice point: corners of the pieces are samples, and
/// nothing is rounded. The convex part inside is triangulated by pulling its first corner
/// (lexicographically), and so are its facets: the triangulation of a facet depends on its own
/// corners only, and both sides agree.
template <int D>
class BorderClip {
 public:
  using Piece = std::array<Index<D>, as_size(D) + 1>;

  explicit BorderClip(const Index<D>& dims);

  /// The part of a simplex of the hierarchy inside the data, as positively oriented simplices:
  /// itself where it is inside; none where it is outside, or touches the border only. Valid until
  /// the next call.
  [[nodiscard]] std::span<const Piece> clip(const Simplex<D>& simplex);

 private:
  using Polygon = std::vector<Index<D>>;

  [[nodiscard]] bool is_inside(const Simplex<D>& simplex) const;
  void clip_polygon(Polygon& polygon);
  void add_fan(Polygon& polygon, const Index<D>* apex);
  void add_piece(Piece piece);
  void clip_faces(const Simplex<D>& simplex);
  void add_border_facets(const Simplex<D>& simplex);

  Index<D> last_;
  std::vector<Polygon> facets_;
  std::vector<Piece> pieces_;
  Polygon scratch_;
};

extern template class BorderClip<2>;
extern template class BorderClip<3>;

/// Six times a tetrahedron's volume, twice a triangle's area; negative where it is turned round.
[[nodiscard]] std::int64_t oriented_size(const std::array<Index<2>, 3>& triangle);
[[nodiscard]] std::int64_t oriented_size(const std::array<Index<3>, 4>& tetrahedron);

}  // namespace lode::diamond
