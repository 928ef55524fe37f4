#include "lode/io/higher_order_cells.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "lode/io/cell_shapes.h"
#include "lode/io/cell_types.h"

namespace lode::io {
namespace {

/// A solid type of higher order, whose corners come first, and the type that these make.
struct OfCorners {
  std::uint8_t type = 0;
  CellType of_corners = CellType::tetrahedron;
};

constexpr std::array<OfCorners, 17> kOfCorners = {{{24, CellType::tetrahedron},
                                                   {25, CellType::hexahedron},
                                                   {26, CellType::wedge},
                                                   {27, CellType::pyramid},
                                                   {29, CellType::hexahedron},
                                                   {31, CellType::wedge},
                                                   {32, CellType::wedge},
                                                   {33, CellType::hexahedron},
                                                   {37, CellType::pyramid},
                                                   {71, CellType::tetrahedron},
                                                   {72, CellType::hexahedron},
                                                   {73, CellType::wedge},
                                                   {74, CellType::pyramid},
                                                   {78, CellType::tetrahedron},
                                                   {79, CellType::hexahedron},
                                                   {80, CellType::wedge},
                                                   {81, CellType::pyramid}}};

const OfCorners* find_of_corners(std::uint8_t type) {
  const auto* const found = std::find_if(kOfCorners.begin(), kOfCorners.end(),
                                         [&](const OfCorners& of) { return of.type == type; });
  return found == kOfCorners.end() ? nullptr : found;
}

/// What a Lagrange cell of so many nodes is called without.
struct Renamed {
  CellType lagrange = CellType::lagrange_tetrahedron;
  std::size_t n_nodes = 0;
  CellType name = CellType::tetrahedron;
};

constexpr std::array<Renamed, 7> kRenamed = {
    {{CellType::lagrange_tetrahedron, 4, CellType::tetrahedron},
     {CellType::lagrange_tetrahedron, 10, CellType::quadratic_tetrahedron},
     {CellType::lagrange_hexahedron, 8, CellType::hexahedron},
     {CellType::lagrange_hexahedron, 27, CellType::triquadratic_hexahedron},
     {CellType::lagrange_wedge, 6, CellType::wedge},
     {CellType::lagrange_wedge, 18, CellType::biquadratic_wedge},
     {CellType::lagrange_pyramid, 5, CellType::pyramid}}};

/// Two runs of a cell's nodes that other programs have in each other's place.
struct Exchange {
  std::uint8_t first = 0;
  std::uint8_t second = 0;
  std::uint8_t n = 0;
};

constexpr std::array<Exchange, 2> kHexahedronExchanges = {{{12, 16, 4}, {18, 19, 1}}};
constexpr std::array<Exchange, 1> kWedgeExchanges = {{{9, 12, 3}}};

std::span<const Exchange> exchanges_of(CellType type) {
  switch (type) {
    case CellType::quadratic_hexahedron:
    case CellType::triquadratic_hexahedron: return kHexahedronExchanges;
    case CellType::quadratic_wedge:
    case CellType::biquadratic_wedge: return kWedgeExchanges;
    default: return {};
  }
}

void exchange(const Exchange& runs, std::span<std::uint32_t> nodes) {
  const auto first = nodes.subspan(runs.first, runs.n);
  std::swap_ranges(first.begin(), first.end(), nodes.subspan(runs.second, runs.n).begin());
}

/// How far nodes are from the middles of their edges, squared, in all.
double off_middles(const CellMesh& mesh, std::span<const std::uint32_t> nodes,
                   std::span<const Edge> edges, std::size_t n_corners) {
  double sum = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Vec3d ends = mesh.points[nodes[edges[i][0]]] + mesh.points[nodes[edges[i][1]]];
    const Vec3d off = mesh.points[nodes[n_corners + i]] - ends * 0.5;
    sum += dot(off, off);
  }
  return sum;
}

/// Whether another order is nearer, which the nodes have then.
bool order_middles_of(CellType type, const CellMesh& mesh, std::span<std::uint32_t> nodes) {
  const std::span<const Edge> edges = edges_of(type);
  const std::size_t n_corners = n_corners_of(type);
  double least = off_middles(mesh, nodes, edges, n_corners);
  const Exchange* best = nullptr;
  for (const Exchange& runs : exchanges_of(type)) {
    exchange(runs, nodes);
    const double off = off_middles(mesh, nodes, edges, n_corners);
    exchange(runs, nodes);
    if (!(off < least)) continue;
    least = off;
    best = &runs;
  }
  if (best != nullptr) exchange(*best, nodes);
  return best != nullptr;
}

std::span<std::uint32_t> nodes_of(CellMesh& mesh, std::size_t cell) {
  return std::span(mesh.corners)
      .subspan(static_cast<std::size_t>(mesh.begins[cell]), mesh.corners_of(cell).size());
}

}  // namespace

bool can_linearise(const CellMesh& mesh, std::size_t cell) {
  const OfCorners* const of = find_of_corners(mesh.types[cell]);
  return of != nullptr && mesh.corners_of(cell).size() >=
                              cell_kind(static_cast<std::uint8_t>(of->of_corners))->n_corners;
}

void name_lagrange_cells(CellMesh& mesh) {
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto* const found =
        std::find_if(kRenamed.begin(), kRenamed.end(), [&](const Renamed& renamed) {
          return mesh.types[cell] == static_cast<std::uint8_t>(renamed.lagrange) &&
                 mesh.corners_of(cell).size() == renamed.n_nodes;
        });
    if (found != kRenamed.end()) mesh.types[cell] = static_cast<std::uint8_t>(found->name);
  }
}

std::uint64_t order_middles(CellMesh& mesh) {
  std::uint64_t n = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto type = static_cast<CellType>(mesh.types[cell]);
    if (exchanges_of(type).empty()) continue;
    n += order_middles_of(type, mesh, nodes_of(mesh, cell)) ? 1 : 0;
  }
  return n;
}

void linearise(CellMesh& mesh) {
  std::size_t to = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto begin = static_cast<std::size_t>(mesh.begins[cell]);
    std::size_t n = static_cast<std::size_t>(mesh.begins[cell + 1]) - begin;
    if (const OfCorners* const of = find_of_corners(mesh.types[cell])) {
      const auto type = static_cast<std::uint8_t>(of->of_corners);
      const std::size_t n_of_type = cell_kind(type)->n_corners;
      if (n >= n_of_type) {
        n = n_of_type;
        mesh.types[cell] = type;
      }
    }
    mesh.begins[cell] = to;
    for (std::size_t i = 0; i < n; ++i) mesh.corners[to++] = mesh.corners[begin + i];
  }
  mesh.begins[mesh.n_cells()] = to;
  mesh.corners.resize(to);
}

}  // namespace lode::io
