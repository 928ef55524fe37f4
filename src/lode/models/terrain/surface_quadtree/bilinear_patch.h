#pragma once

#include "lode/delaunay/predicates.h"
#include "lode/locate/tin_height.h"
#include "lode/models/terrain/squares/square_domain.h"

namespace lode::surface_quadtree {

/// The height of a square that is wholly in the domain, bilinear between its corners, at the place
/// of it that is nearest to p (column and row): at a corner the sample's, exactly.
[[nodiscard]] TinHeight height_in(const squares::SquareDomain& domain,
                                  const squares::Square& square, const delaunay::Point& p);

/// By how much the surface of a square twists: what its slope along columns grows by with each row.
/// Along a segment over `dx` columns and `dy` rows it is a parabola, which is |twist dx dy| / 4 at
/// most from its chord.
[[nodiscard]] double twist_of(const squares::SquareDomain& domain, const squares::Square& square);

/// How far the surface of a square may be from that of all samples, linear on two triangles a cell,
/// anywhere in it, whichever diagonals cells are cut along; `error`: at its samples. The two differ
/// by a saddle on each triangle, so most on its sides: by what is linear along columns and rows,
/// where samples bound it, and a parabola along a diagonal, over a column and a row.
[[nodiscard]] double error_everywhere(const squares::SquareDomain& domain,
                                      const squares::Square& square, double error);

}  // namespace lode::surface_quadtree
