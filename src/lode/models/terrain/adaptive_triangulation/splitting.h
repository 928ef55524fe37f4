#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "lode/delaunay/lattice.h"

namespace lode::adaptive_triangulation {

using delaunay::LatticePoint;

/// The five ways to split a triangle: figure 15 of L. De Floriani, P. Marzano, E. Puppo 1996, after
/// L. Scarlatos, T. Pavlidis, "Hierarchical triangulation using cartographic coherence", 1992.
enum class Rule : std::uint8_t { centre, edge, edge_and_centre, two_edges, three_edges };
inline constexpr std::size_t kRules = 5;

/// A triangle, turning left, and what is to be inserted: at least one place.
struct Insertion {
  std::array<LatticePoint, 3> corner;
  /// On the edge from corner i to corner i + 1, or next to it.
  std::array<std::optional<LatticePoint>, 3> on_edge;
  std::optional<LatticePoint> centre;  ///< Inside.
};

/// Triangles as numbers: 0 to 2 for corners, 3 to 5 for the edges' places, 6 for the centre.
struct Split {
  Rule rule = Rule::centre;
  std::size_t n_triangles = 0;
  std::array<std::array<std::uint8_t, 3>, 4> triangles{};
};

/// Splits a triangle by the rule for what is to be inserted; with places on two or three edges the
/// centre waits. Of two places, the one is joined to the corner opposite to it that is closer to it
/// than the other to its; the first one's of equals. All triangles turn left: where the centre does
/// not see all that it must, as a place is not quite on its edge, it waits, too, and where there is
/// no way at all, there is no split. With all places exactly on their edges there always is one.
[[nodiscard]] std::optional<Split> split_triangle(const Insertion& insertion);

}  // namespace lode::adaptive_triangulation
