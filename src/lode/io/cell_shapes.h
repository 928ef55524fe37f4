#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/core/cell_mesh.h"

namespace lode::io {

/// Places of a face's corners in its cell, seen from outside; the last twice in triangles.
using Face = std::array<std::uint8_t, 4>;
/// Places of an edge's ends.
using Edge = std::array<std::uint8_t, 2>;

constexpr std::size_t n_corners(const Face& face) { return face[2] == face[3] ? 3 : 4; }

constexpr std::array<Face, 6> kHexahedronFaces = {
    {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};
constexpr std::array<Face, 5> kWedgeFaces = {
    {{0, 2, 1, 1}, {3, 4, 5, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}};
constexpr std::array<Face, 5> kPyramidFaces = {
    {{0, 3, 2, 1}, {0, 1, 4, 4}, {1, 2, 4, 4}, {2, 3, 4, 4}, {3, 0, 4, 4}}};

/// Edges in the order in which VTK has their middles behind the corners of quadratic cells.
constexpr std::array<Edge, 6> kTetrahedronEdges = {
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
constexpr std::array<Edge, 12> kHexahedronEdges = {{{0, 1},
                                                    {1, 2},
                                                    {2, 3},
                                                    {3, 0},
                                                    {4, 5},
                                                    {5, 6},
                                                    {6, 7},
                                                    {7, 4},
                                                    {0, 4},
                                                    {1, 5},
                                                    {2, 6},
                                                    {3, 7}}};
constexpr std::array<Edge, 9> kWedgeEdges = {
    {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
constexpr std::array<Edge, 8> kPyramidEdges = {
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};
/// Of voxels, whose corners are in another order.
constexpr std::array<Edge, 12> kVoxelEdges = {{{0, 1},
                                               {1, 3},
                                               {3, 2},
                                               {2, 0},
                                               {4, 5},
                                               {5, 7},
                                               {7, 6},
                                               {6, 4},
                                               {0, 4},
                                               {1, 5},
                                               {3, 7},
                                               {2, 6}}};

/// Of solid types with corners and edges that are known, linear or quadratic; none of others.
[[nodiscard]] std::span<const Edge> edges_of(CellType type);
/// Of those.
[[nodiscard]] std::size_t n_corners_of(CellType type);

}  // namespace lode::io
