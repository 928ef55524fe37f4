#include "lode/io/higher_order_cells.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lode/io/cell_shapes.h"
#include "lode/io/cell_types.h"
#include "lode/io/quadratic_cells.h"

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

std::span<const Edge> edges_of(CellType type) {
  switch (type) {
    case CellType::tetrahedron:
    case CellType::quadratic_tetrahedron: return kTetrahedronEdges;
    case CellType::voxel: return kVoxelEdges;
    case CellType::hexahedron:
    case CellType::quadratic_hexahedron:
    case CellType::triquadratic_hexahedron: return kHexahedronEdges;
    case CellType::wedge:
    case CellType::quadratic_wedge:
    case CellType::biquadratic_wedge: return kWedgeEdges;
    case CellType::pyramid:
    case CellType::quadratic_pyramid:
    case CellType::lagrange_pyramid: return kPyramidEdges;
    default: return {};
  }
}

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
  const std::size_t n_corners =
      type == CellType::quadratic_wedge || type == CellType::biquadratic_wedge ? 6 : 8;
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

bool is_quadratic(const CellMesh& mesh, std::size_t cell) {
  return static_cast<CellType>(mesh.types[cell]) == CellType::quadratic_tetrahedron ||
         quadratic_shape(mesh, cell).has_value();
}

/// The corners of an edge or of a face with four, ascending; and whether a node is in the middle.
struct Shared {
  std::array<std::uint32_t, 4> corners{};
  bool has_middle = false;

  friend auto operator<=>(const Shared&, const Shared&) = default;
};

/// What lies at the same corners with a node and without one.
struct Disagreement {
  std::size_t n = 0;
  Shared first;
};

Disagreement find_disagreement(std::vector<Shared> all) {
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  Disagreement found;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].corners == all[i - 1].corners && found.n++ == 0) found.first = all[i];
  return found;
}

/// Edges of all solid cells, their two corners twice.
std::vector<Shared> list_edges(const CellMesh& mesh) {
  std::vector<Shared> edges;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto nodes = mesh.corners_of(cell);
    const bool has_middle = is_quadratic(mesh, cell);
    for (const auto& [i, j] : edges_of(static_cast<CellType>(mesh.types[cell]))) {
      const auto [a, b] = std::minmax(nodes[i], nodes[j]);
      if (a != b) edges.push_back({{a, a, b, b}, has_middle});
    }
  }
  return edges;
}

/// Faces of quadratic cells with four corners.
std::vector<Shared> list_faces(const CellMesh& mesh) {
  std::vector<Shared> faces;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto shape = quadratic_shape(mesh, cell);
    if (!shape) continue;
    const auto nodes = mesh.corners_of(cell);
    for (const QuadraticFace& face : shape->faces) {
      if (n_corners(face.corners) < 4) continue;
      Shared shared{.has_middle = face.centre.has_value()};
      for (std::size_t i = 0; i < 4; ++i) shared.corners[i] = nodes[face.corners[i]];
      std::sort(shared.corners.begin(), shared.corners.end());
      faces.push_back(shared);
    }
  }
  return faces;
}

/// Which solid cells a mesh has.
struct Kinds {
  std::size_t n_linear = 0;
  std::size_t n_polyhedra = 0;
  std::size_t n_quadratic = 0;
  bool has_faces_with_middles = false;
  bool has_faces_without = false;
};

Kinds kinds_of(const CellMesh& mesh) {
  Kinds kinds;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto type = static_cast<CellType>(mesh.types[cell]);
    if (type == CellType::polyhedron) ++kinds.n_polyhedra;
    if (edges_of(type).empty()) continue;
    ++(is_quadratic(mesh, cell) ? kinds.n_quadratic : kinds.n_linear);
    if (const auto shape = quadratic_shape(mesh, cell))
      for (const QuadraticFace& face : shape->faces)
        if (n_corners(face.corners) == 4)
          (face.centre ? kinds.has_faces_with_middles : kinds.has_faces_without) = true;
  }
  return kinds;
}

}  // namespace

bool can_linearise(std::uint8_t type) { return find_of_corners(type) != nullptr; }

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

Result<void> check_shared_nodes(const CellMesh& mesh) {
  constexpr const char* kAdvice = "linearised to their corners (--linearise corners) they do";
  const Kinds kinds = kinds_of(mesh);
  if (kinds.n_quadratic == 0) return {};
  if (kinds.n_polyhedra > 0)
    return fail(
        "{}: expected quadratic cells without polyhedra beside them, whose faces would not meet "
        "theirs, got {} and {}: {}",
        mesh.path, kinds.n_quadratic, kinds.n_polyhedra, kAdvice);
  if (kinds.n_linear > 0)
    if (const auto found = find_disagreement(list_edges(mesh)); found.n > 0)
      return fail(
          "{}: expected cells at an edge to have a node in its middle all or none, got {} edges of "
          "quadratic and other cells, the first between points {} and {}: {}",
          mesh.path, found.n, found.first.corners[0], found.first.corners[2], kAdvice);
  if (kinds.has_faces_with_middles && kinds.has_faces_without)
    if (const auto found = find_disagreement(list_faces(mesh)); found.n > 0)
      return fail(
          "{}: expected both cells at a face to have a node in its middle or neither, got {} faces "
          "of which one has, the first at points {}: {}",
          mesh.path, found.n, fmt::join(found.first.corners, ", "), kAdvice);
  return {};
}

}  // namespace lode::io
