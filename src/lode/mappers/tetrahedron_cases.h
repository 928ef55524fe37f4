#pragma once

#include <array>
#include <cstdint>

namespace lode {

/// Even permutations of a tetrahedron's vertices, by the set of inside vertices (as bits): the
/// inside ones first where there are one or two, the single outside one first where there are
/// three. With o = kTetrahedronOrder[inside] and ij the vertex on the edge o[i] – o[j], a
/// positively oriented tetrahedron's triangles, counter-clockwise seen from the outside
/// vertices, are: one inside: 01 02 03; two: 02 03 13 and 02 13 12; three: 01 03 02.
inline constexpr std::array<std::array<std::uint8_t, 4>, 16> kTetrahedronOrder = {{
    {0, 1, 2, 3},
    {0, 1, 2, 3},
    {1, 0, 3, 2},
    {0, 1, 2, 3},
    {2, 0, 1, 3},
    {0, 2, 3, 1},
    {1, 2, 0, 3},
    {3, 0, 2, 1},
    {3, 0, 2, 1},
    {0, 3, 1, 2},
    {1, 3, 2, 0},
    {2, 0, 1, 3},
    {2, 3, 0, 1},
    {1, 0, 3, 2},
    {0, 1, 2, 3},
    {0, 1, 2, 3},
}};

}  // namespace lode
