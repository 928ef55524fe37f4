#include "lode/mappers/kuhn_cube.h"

#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "lode/mappers/tetrahedron_cases.h"

namespace lode {
namespace {

struct KuhnTetrahedron {
  std::array<CellCorner, 4> corner;
  bool is_positive;
};

/// The six simplices run from the corner with even coordinates to the one with odd ones.
std::array<KuhnTetrahedron, 6> tetrahedra_of(int parity) {
  std::array<int, 3> order{0, 1, 2};
  std::array<KuhnTetrahedron, 6> result{};
  const bool is_reflected = (std::popcount(static_cast<unsigned>(parity)) & 1) != 0;
  for (KuhnTetrahedron& t : result) {
    int odd_axes = 0;
    t.corner[0] = static_cast<CellCorner>(parity);
    for (std::size_t i = 0; i < 3; ++i) {
      odd_axes |= 1 << order[i];
      t.corner[i + 1] = static_cast<CellCorner>(odd_axes ^ parity);
    }
    const bool is_even_order = (order[1] - order[0] + 3) % 3 == 1;
    t.is_positive = is_even_order != is_reflected;
    std::next_permutation(order.begin(), order.end());
  }
  return result;
}

class CaseBuilder {
 public:
  void add(const KuhnTetrahedron& t, std::size_t inside, bool flip) {
    const auto& o = kTetrahedronOrder[inside];
    const auto vertex = [&](std::size_t i, std::size_t j) {
      return local(cell_edge(t.corner[o[i]], t.corner[o[j]]));
    };
    const auto put = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c) {
      out_.triangles[out_.n_triangles++] = {a, flip ? c : b, flip ? b : c};
    };
    const int n_inside = std::popcount(inside);
    if (n_inside == 1) put(vertex(0, 1), vertex(0, 2), vertex(0, 3));
    if (n_inside == 3) put(vertex(0, 1), vertex(0, 3), vertex(0, 2));
    if (n_inside == 2) {
      put(vertex(0, 2), vertex(0, 3), vertex(1, 3));
      put(vertex(0, 2), vertex(1, 3), vertex(1, 2));
    }
  }
  [[nodiscard]] const KuhnCubeCase& result() const { return out_; }

 private:
  std::uint8_t local(CellEdge edge) {
    const auto end = out_.edges.begin() + out_.n_edges;
    const auto at = std::find(out_.edges.begin(), end, edge);
    if (at == end) out_.edges[out_.n_edges++] = edge;
    return static_cast<std::uint8_t>(at - out_.edges.begin());
  }

  KuhnCubeCase out_;
};

KuhnCubeCases make_cases(std::span<const KuhnTetrahedron> tetrahedra, bool is_mirrored) {
  KuhnCubeCases cases;
  for (std::size_t corners = 0; corners < cases.size(); ++corners) {
    CaseBuilder builder;
    for (const KuhnTetrahedron& t : tetrahedra) {
      std::size_t inside = 0;
      for (std::size_t i = 0; i < 4; ++i) inside |= ((corners >> t.corner[i]) & 1) << i;
      builder.add(t, inside, t.is_positive == is_mirrored);
    }
    cases[corners] = builder.result();
  }
  return cases;
}

std::array<KuhnCubeCases, 8> make_all_cases(bool is_mirrored) {
  std::array<KuhnCubeCases, 8> all;
  for (std::size_t parity = 0; parity < 8; ++parity)
    all[parity] = make_cases(tetrahedra_of(static_cast<int>(parity)), is_mirrored);
  return all;
}

std::array<std::array<CellCorner, 2>, 32> make_edge_corners() {
  std::array<std::array<CellCorner, 2>, 32> corners{};
  for (CellCorner a = 0; a < 8; ++a)
    for (CellCorner b = 0; b < 8; ++b)
      if (a != b && (a & b) == a) corners[cell_edge(a, b)] = {a, b};
  return corners;
}

}  // namespace

CellEdge cell_edge(CellCorner a, CellCorner b) {
  const int anchor = a & b;
  const int series = edge_series(a ^ b, (anchor >> 1) & 1, (anchor >> 2) & 1);
  return static_cast<CellEdge>(series + 16 * (anchor & 1));
}

std::array<CellCorner, 2> edge_corners(CellEdge edge) {
  static const std::array<std::array<CellCorner, 2>, 32> kCorners = make_edge_corners();
  return kCorners[edge];
}

const KuhnCubeCases& kuhn_cube_cases(int parity, bool is_mirrored) {
  static const std::array<KuhnCubeCases, 8> kRightHanded = make_all_cases(false);
  static const std::array<KuhnCubeCases, 8> kMirrored = make_all_cases(true);
  return (is_mirrored ? kMirrored : kRightHanded)[static_cast<std::size_t>(parity)];
}

KuhnCubeCases kuhn_cube_cases_along(unsigned first_axes) {
  std::vector<KuhnTetrahedron> some;
  for (const KuhnTetrahedron& t : tetrahedra_of(0))
    if ((t.corner[1] & first_axes) != 0) some.push_back(t);
  return make_cases(some, false);
}

}  // namespace lode
