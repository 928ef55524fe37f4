// The cells of the style of cubes, by enumeration.

#include "lode/mappers/cube_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <vector>

namespace lode {
namespace {

using EdgeEnds = std::array<CellCorner, 2>;
using EdgeTriple = std::array<EdgeEnds, 3>;
using DirectedEdge = std::pair<EdgeEnds, EdgeEnds>;

std::vector<EdgeTriple> triangles_of(const KuhnCubeCase& c) {
  std::vector<EdgeTriple> triangles;
  for (std::size_t t = 0; t < c.n_triangles; ++t) {
    EdgeTriple& triangle = triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) triangle[i] = edge_corners(c.edges[c.triangles[t][i]]);
  }
  return triangles;
}

int n_axes(const EdgeEnds& e) { return std::popcount(static_cast<unsigned>(e[0] ^ e[1])); }

/// Bit 2·axis for the lower face of a cell, the next for the upper: those that all of these lie in.
template <typename Edges>
unsigned faces_of(const Edges& edges) {
  unsigned faces = 63;
  for (const EdgeEnds& e : edges)
    for (const unsigned corner : e)
      for (unsigned axis = 0; axis < 3; ++axis)
        faces &= ~(1U << (2 * axis + ((corner >> axis & 1) == 0 ? 1 : 0)));
  return faces;
}

/// What a patch is but for where its vertices are: edges that run along it once, in its sense, with
/// vertices on face diagonals left out; and its pieces' Euler numbers. Empty where it is no
/// manifold.
struct PatchTopology {
  std::set<DirectedEdge> boundary;
  std::multiset<int> euler_numbers;

  friend bool operator==(const PatchTopology&, const PatchTopology&) = default;
};

/// Pieces by their lowest vertex.
std::map<EdgeEnds, EdgeEnds> pieces_of(const std::vector<EdgeTriple>& triangles) {
  std::map<EdgeEnds, EdgeEnds> piece;
  for (const EdgeTriple& t : triangles)
    for (const EdgeEnds& v : t) piece.emplace(v, v);
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const EdgeTriple& t : triangles) {
      const EdgeEnds lowest = std::min({piece[t[0]], piece[t[1]], piece[t[2]]});
      for (const EdgeEnds& v : t) {
        is_changed = is_changed || piece[v] != lowest;
        piece[v] = lowest;
      }
    }
  }
  return piece;
}

PatchTopology topology_of(const std::vector<EdgeTriple>& triangles) {
  std::map<DirectedEdge, int> runs;
  for (const EdgeTriple& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) ++runs[{t[i], t[(i + 1) % 3]}];
  const auto piece = pieces_of(triangles);
  std::map<EdgeEnds, int> euler;
  std::map<EdgeEnds, EdgeEnds> next;
  for (const auto& [vertex, lowest] : piece) ++euler[lowest];
  for (const EdgeTriple& t : triangles) ++euler[piece.at(t[0])];
  for (const auto& [edge, n] : runs) {
    EXPECT_EQ(n, 1) << "an edge runs twice the same way";
    const bool is_inner = runs.contains({edge.second, edge.first});
    if (!is_inner || edge.first < edge.second) --euler[piece.at(edge.first)];
    if (is_inner) continue;
    EXPECT_NE(faces_of(std::array{edge.first, edge.second}), 0U) << "ends inside the cell";
    EXPECT_TRUE(next.emplace(edge).second) << "two fans at a vertex";
  }
  PatchTopology topology;
  for (const auto& [lowest, number] : euler) topology.euler_numbers.insert(number);
  for (const auto& [from, to] : next) {
    if (n_axes(from) == 2) continue;
    topology.boundary.emplace(from, n_axes(to) == 2 ? next.at(to) : to);
  }
  return topology;
}

struct Cell {
  int parity;
  bool is_mirrored;
};

std::vector<Cell> all_cells() {
  std::vector<Cell> cells;
  for (int parity = 0; parity < 8; ++parity)
    for (const bool is_mirrored : {false, true}) cells.push_back({parity, is_mirrored});
  return cells;
}

TEST(cube_cases, have_the_topology_and_the_ends_of_the_tetrahedra_s) {
  for (const auto& [parity, is_mirrored] : all_cells())
    for (unsigned corners = 0; corners < 256; ++corners) {
      SCOPED_TRACE(corners);
      const auto cubes = triangles_of(cube_cases(parity, is_mirrored)[corners]);
      const auto tetra = triangles_of(kuhn_cube_cases(parity, is_mirrored)[corners]);
      ASSERT_EQ(topology_of(cubes), topology_of(tetra));
    }
}

TEST(cube_cases, have_vertices_on_all_crossed_grid_edges_and_14_times_on_the_body_diagonal) {
  int n_with_body_vertex = 0;
  for (unsigned corners = 0; corners < 256; ++corners) {
    n_with_body_vertex += needs_body_vertex(corners) ? 1 : 0;
    const KuhnCubeCase& c = cube_cases(0, false)[corners];
    std::set<EdgeEnds> vertices;
    for (std::size_t e = 0; e < c.n_edges; ++e) vertices.insert(edge_corners(c.edges[e]));
    for (CellCorner a = 0; a < 8; ++a)
      for (CellCorner b = 0; b < 8; ++b) {
        if (a == b || (a & b) != a) continue;
        const EdgeEnds e{a, b};
        const bool is_crossed = ((corners >> a ^ corners >> b) & 1) != 0;
        const bool is_wanted = n_axes(e) == 1 || (n_axes(e) == 3 && needs_body_vertex(corners));
        EXPECT_EQ(vertices.contains(e), is_crossed && is_wanted) << corners;
      }
  }
  EXPECT_EQ(n_with_body_vertex, 14);
}

TEST(cube_cases, have_only_pieces_that_are_discs_or_one_annulus) {
  int n_annuli = 0;
  for (unsigned corners = 1; corners < 255; ++corners) {
    const auto topology = topology_of(triangles_of(cube_cases(0, false)[corners]));
    for (const int number : topology.euler_numbers) {
      n_annuli += number == 0 ? 1 : 0;
      EXPECT_TRUE(number == 1 || topology.euler_numbers.size() == 1) << corners;
    }
  }
  // The even and the odd corner against all others, either way.
  EXPECT_EQ(n_annuli, 2);
}

TEST(cube_cases, meet_a_face_only_in_their_boundary) {
  for (unsigned corners = 0; corners < 256; ++corners) {
    const auto triangles = triangles_of(cube_cases(0, false)[corners]);
    const PatchTopology topology = topology_of(triangles);
    for (const EdgeTriple& t : triangles) {
      EXPECT_EQ(faces_of(t), 0U) << "a triangle in a face, " << corners;
      for (std::size_t i = 0; i < 3; ++i) {
        const DirectedEdge edge{t[i], t[(i + 1) % 3]};
        if (faces_of(std::array{edge.first, edge.second}) != 0)
          EXPECT_TRUE(topology.boundary.contains(edge)) << "a chord in a face, " << corners;
      }
    }
  }
}

/// The patch's boundary in a face, as seen from a neighbour's coordinates.
std::set<DirectedEdge> ends_in_face(const PatchTopology& topology, unsigned face, unsigned moved) {
  std::set<DirectedEdge> ends;
  const auto move = [&](const EdgeEnds& e) {
    return EdgeEnds{static_cast<CellCorner>(e[0] ^ moved), static_cast<CellCorner>(e[1] ^ moved)};
  };
  for (const DirectedEdge& e : topology.boundary)
    if ((faces_of(std::array{e.first, e.second}) >> face & 1) != 0)
      ends.emplace(move(e.first), move(e.second));
  return ends;
}

TEST(cube_cases, agree_with_every_neighbour_across_faces) {
  for (const auto& [parity, is_mirrored] : all_cells())
    for (unsigned axis = 0; axis < 3; ++axis) {
      const unsigned upper = 1U << axis;
      // By the signs in the common face: what either side makes of it.
      std::map<unsigned, std::set<DirectedEdge>> below;
      for (unsigned corners = 0; corners < 256; ++corners) {
        unsigned signs = 0;
        for (unsigned k = 0; k < 8; ++k)
          if ((k & upper) != 0) signs |= (corners >> k & 1) << (k ^ upper);
        const auto ends =
            ends_in_face(topology_of(triangles_of(cube_cases(parity, is_mirrored)[corners])),
                         2 * axis + 1, upper);
        EXPECT_EQ(below.emplace(signs, ends).first->second, ends);
      }
      const int beyond = parity ^ static_cast<int>(upper);
      for (unsigned corners = 0; corners < 256; ++corners) {
        unsigned signs = 0;
        for (unsigned k = 0; k < 8; ++k)
          if ((k & upper) == 0) signs |= (corners >> k & 1) << k;
        std::set<DirectedEdge> turned;
        for (const DirectedEdge& e : below.at(signs)) turned.emplace(e.second, e.first);
        ASSERT_EQ(ends_in_face(topology_of(triangles_of(cube_cases(beyond, is_mirrored)[corners])),
                               2 * axis, 0),
                  turned)
            << "axis " << axis << ", corners " << corners;
      }
    }
}

using IntegerPoint = std::array<int, 3>;

IntegerPoint point_on(const EdgeEnds& e, bool at_end) {
  const unsigned corner = e[at_end ? 1 : 0];
  return {static_cast<int>(corner & 1), static_cast<int>(corner >> 1 & 1),
          static_cast<int>(corner >> 2 & 1)};
}

int determinant_of(const IntegerPoint& a, const IntegerPoint& b, const IntegerPoint& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

IntegerPoint difference(const IntegerPoint& a, const IntegerPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// 1 or -1: the sign that f has wherever on their edges, ends excepted, n vertices are, if f is
/// linear in each of their places: it is enough to look at the ends. 0: no such sign.
template <typename Function>
int constant_sign(int n, const Function& f) {
  bool has_positive = false;
  bool has_negative = false;
  for (unsigned ends = 0; ends < 1U << n; ++ends) {
    const int value = f(ends);
    has_positive = has_positive || value > 0;
    has_negative = has_negative || value < 0;
  }
  return has_positive == has_negative ? 0 : has_positive ? 1 : -1;
}

/// The side of the plane through three vertices, on different edges, that a fourth one is on.
int side_of(const EdgeTriple& plane, const EdgeEnds& vertex) {
  return constant_sign(4, [&](unsigned ends) {
    const IntegerPoint origin = point_on(plane[0], (ends & 1) != 0);
    return determinant_of(difference(point_on(plane[1], (ends & 2) != 0), origin),
                          difference(point_on(plane[2], (ends & 4) != 0), origin),
                          difference(point_on(vertex, (ends & 8) != 0), origin));
  });
}

/// Whether a triangle is counter-clockwise seen against a direction (1), or clockwise (-1).
int turn_of(const EdgeTriple& t, const IntegerPoint& direction) {
  return constant_sign(3, [&](unsigned ends) {
    const IntegerPoint origin = point_on(t[0], (ends & 1) != 0);
    return determinant_of(difference(point_on(t[1], (ends & 2) != 0), origin),
                          difference(point_on(t[2], (ends & 4) != 0), origin), direction);
  });
}

std::vector<IntegerPoint> directions() {
  std::vector<IntegerPoint> result;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) result.push_back({x, y, z});
  return result;
}

bool has_vertex(const EdgeTriple& t, const EdgeEnds& v) {
  return std::ranges::find(t, v) != t.end();
}

/// A plane through three of their vertices, of which each triangle has some, keeps the rest of one
/// triangle on one side and that of the other on the other.
bool are_apart_by_a_vertex_plane(const EdgeTriple& a, const EdgeTriple& b) {
  std::set<EdgeEnds> all(a.begin(), a.end());
  all.insert(b.begin(), b.end());
  const std::vector<EdgeEnds> v(all.begin(), all.end());
  for (std::size_t i = 0; i < v.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < j; ++k) {
        const EdgeTriple plane{v[i], v[j], v[k]};
        std::set<int> sides_of_a;
        std::set<int> sides_of_b;
        for (const EdgeEnds& w : a)
          if (!has_vertex(plane, w)) sides_of_a.insert(side_of(plane, w));
        for (const EdgeEnds& w : b)
          if (!has_vertex(plane, w)) sides_of_b.insert(side_of(plane, w));
        const auto is_side = [](const std::set<int>& sides, int side) {
          return std::ranges::all_of(sides, [&](int s) { return s == side; });
        };
        if (sides_of_a.empty() && sides_of_b.empty()) continue;
        for (const int side : {1, -1})
          if (is_side(sides_of_a, side) && is_side(sides_of_b, -side)) return true;
      }
  return false;
}

/// One of the planes x_i = x_j, which tetrahedra share, lies between them.
bool are_apart_by_a_tetrahedron_plane(const EdgeTriple& a, const EdgeTriple& b) {
  const auto is_beyond = [](const EdgeTriple& t, std::size_t i, std::size_t j) {
    return std::ranges::all_of(t, [&](const EdgeEnds& e) {
      return constant_sign(1, [&](unsigned end) {
               const IntegerPoint p = point_on(e, end != 0);
               return p[i] - p[j];
             }) == 1;
    });
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (i != j && is_beyond(a, i, j) && is_beyond(b, j, i)) return true;
  return false;
}

/// Neighbours that are not folded onto each other: some direction sees both from the same side.
bool is_unfolded(const EdgeTriple& a, const EdgeTriple& b) {
  return std::ranges::any_of(directions(), [&](const IntegerPoint& d) {
    return turn_of(a, d) != 0 && turn_of(a, d) == turn_of(b, d);
  });
}

/// Their vertices are seen as a convex polygon along some direction.
bool is_convex(const std::set<EdgeEnds>& vertices, const std::set<DirectedEdge>& boundary) {
  std::map<EdgeEnds, EdgeEnds> next(boundary.begin(), boundary.end());
  std::vector<EdgeEnds> loop{*vertices.begin()};
  while (next.contains(loop.back()) && next.at(loop.back()) != loop.front())
    loop.push_back(next.at(loop.back()));
  if (loop.size() != vertices.size()) return false;  // with a vertex inside, or an annulus
  return std::ranges::any_of(directions(), [&](const IntegerPoint& d) {
    std::set<int> turns;
    for (std::size_t k = 0; k < loop.size(); ++k)
      for (std::size_t j = 0; j < k; ++j)
        for (std::size_t i = 0; i < j; ++i) turns.insert(turn_of({loop[i], loop[j], loop[k]}, d));
    return turns.size() == 1 && !turns.contains(0);
  });
}

TEST(cube_cases, do_not_cut_themselves_wherever_the_vertices_are) {
  constexpr EdgeEnds kBody{0, 7};
  for (unsigned corners = 0; corners < 256; ++corners) {
    const auto triangles = triangles_of(cube_cases(0, false)[corners]);
    const auto boundary = topology_of(triangles).boundary;
    const auto piece = pieces_of(triangles);
    std::map<EdgeEnds, std::set<EdgeEnds>> vertices;
    for (const auto& [vertex, lowest] : piece) vertices[lowest].insert(vertex);
    std::set<EdgeEnds> convex;
    for (const auto& [lowest, all] : vertices)
      if (is_convex(all, boundary)) convex.insert(lowest);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const EdgeTriple& a = triangles[i];
        const EdgeTriple& b = triangles[j];
        // Seen from the vertex inside, a loop in the cell's faces does not overlap itself.
        if (has_vertex(a, kBody) && has_vertex(b, kBody)) continue;
        if (piece.at(a[0]) == piece.at(b[0]) && convex.contains(piece.at(a[0]))) continue;
        const auto n_common =
            std::ranges::count_if(a, [&](const EdgeEnds& v) { return has_vertex(b, v); });
        EXPECT_TRUE(n_common == 2 ? is_unfolded(a, b)
                                  : are_apart_by_a_tetrahedron_plane(a, b) ||
                                        are_apart_by_a_vertex_plane(a, b))
            << "corners " << corners << ", triangles " << j << " and " << i;
      }
  }
}

}  // namespace
}  // namespace lode
