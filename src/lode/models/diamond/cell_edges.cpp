#include "lode/models/diamond/cell_edges.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "lode/mappers/cube_cases.h"

namespace lode::diamond {
namespace {

/// Of a cell whose lowest corner has this parity.
CellEdgeEnds ends_of(CellEdge edge, unsigned parity) {
  const auto [a, b] = edge_corners(edge);
  const unsigned direction = a ^ b;
  const unsigned even = (a ^ parity) & ~direction;
  return {static_cast<std::uint8_t>(even), static_cast<std::uint8_t>(even | direction)};
}

constexpr int kCanonical = 0;

/// All edges of a cell, as ends.
std::array<CellEdgeEnds, CellEdges::kEdges> make_all_ends_of_cell() {
  std::array<CellEdgeEnds, CellEdges::kEdges> edges{};
  std::size_t n = 0;
  for (const KuhnCubeCase& c : kuhn_cube_cases(kCanonical, false))
    for (std::size_t e = 0; e < c.n_edges; ++e) {
      const CellEdgeEnds ends = ends_of(c.edges[e], kCanonical);
      const auto last = edges.begin() + static_cast<std::ptrdiff_t>(n);
      if (std::find(edges.begin(), last, ends) == last) edges[n++] = ends;
    }
  std::stable_partition(edges.begin(), edges.end(), [](const CellEdgeEnds& e) {
    return std::popcount<unsigned>(e[0] ^ e[1]) != 2;
  });
  return edges;
}

std::size_t number_of(const CellEdgeEnds& ends) {
  const auto& all = cell_edge_ends();
  return static_cast<std::size_t>(std::find(all.begin(), all.end(), ends) - all.begin());
}

const KuhnCubeCases& cases_of(int parity, bool is_mirrored, SurfaceStyle style) {
  return style == SurfaceStyle::cubes ? cube_cases(parity, is_mirrored)
                                      : kuhn_cube_cases(parity, is_mirrored);
}

CellEdges make_edges(int parity, bool is_mirrored, SurfaceStyle style) {
  CellEdges result;
  result.by_corners = &cases_of(parity, is_mirrored, style);
  result.is_flipped = ((std::popcount(static_cast<unsigned>(parity)) & 1) != 0) != is_mirrored;
  for (const KuhnCubeCase& c : *result.by_corners)
    for (std::size_t e = 0; e < c.n_edges; ++e)
      result.edge[number_of(ends_of(c.edges[e], static_cast<unsigned>(parity)))] = c.edges[e];
  return result;
}

std::array<CellEdges, 16> make_all_edges(SurfaceStyle style) {
  std::array<CellEdges, 16> all;
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = make_edges(static_cast<int>(i % 8), i >= 8, style);
  return all;
}

std::array<CellCase, 256> make_cases(const KuhnCubeCases& all) {
  std::array<CellCase, 256> cases{};
  for (std::size_t corners = 0; corners < cases.size(); ++corners) {
    const KuhnCubeCase& from = all[corners];
    std::size_t i = 0;
    for (std::size_t t = 0; t < from.n_triangles; ++t)
      for (const std::uint8_t e : from.triangles[t])
        cases[corners].edge[i++] =
            static_cast<std::uint8_t>(number_of(ends_of(from.edges[e], kCanonical)));
    cases[corners].n_ends = static_cast<std::uint8_t>(i);
  }
  return cases;
}

std::vector<CellCase> make_cases_by_axes() {
  std::vector<CellCase> cases;
  for (unsigned axes = 0; axes < 8; ++axes) {
    const auto some = make_cases(kuhn_cube_cases_along(axes));
    cases.insert(cases.end(), some.begin(), some.end());
  }
  return cases;
}

}  // namespace

const std::array<CellEdgeEnds, CellEdges::kEdges>& cell_edge_ends() {
  static const std::array<CellEdgeEnds, CellEdges::kEdges> kEnds = make_all_ends_of_cell();
  return kEnds;
}

const CellCase* cell_cases(SurfaceStyle style) {
  static const auto kTetra = make_cases(cases_of(kCanonical, false, SurfaceStyle::tetra));
  static const auto kCubes = make_cases(cases_of(kCanonical, false, SurfaceStyle::cubes));
  return style == SurfaceStyle::cubes ? kCubes.data() : kTetra.data();
}

const CellCase* cell_cases_by_axes() {
  static const std::vector<CellCase> kCases = make_cases_by_axes();
  return kCases.data();
}

const CellEdges& cell_edges(int parity, bool is_mirrored, SurfaceStyle style) {
  static const std::array<CellEdges, 16> kTetra = make_all_edges(SurfaceStyle::tetra);
  static const std::array<CellEdges, 16> kCubes = make_all_edges(SurfaceStyle::cubes);
  const auto& all = style == SurfaceStyle::cubes ? kCubes : kTetra;
  return all[static_cast<std::size_t>(parity) + (is_mirrored ? 8U : 0U)];
}

}  // namespace lode::diamond
