#include "lode/models/terrain/tile_pyramid/tile_mesh.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "lode/core/expects.h"
#include "lode/core/height_frame.h"
#include "lode/delaunay/point_insertion.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {
namespace {

using delaunay::doubled_area;
using delaunay::kNoHalfEdge;
using delaunay::LatticeTriangle;
using delaunay::ListedNodes;
using delaunay::PointMesh;
using delaunay::PointSamples;

/// Nodes, and heights by node.
struct NodeTable {
  std::vector<LatticePoint> nodes;
  std::vector<double> heights;

  void add(const TileVertex& vertex) {
    nodes.push_back(vertex.node);
    heights.push_back(vertex.height);
  }
};

std::uint32_t key_of(LatticePoint node) {
  return (static_cast<std::uint32_t>(node.y) << 15) | static_cast<std::uint32_t>(node.x);
}

/// The mesh's vertices, then candidates at nodes of their own.
NodeTable to_table(const TileMesh& mesh, std::span<const TileVertex> candidates) {
  NodeTable table;
  std::unordered_set<std::uint32_t> taken;
  taken.reserve(mesh.vertices.size() + candidates.size());
  for (const TileVertex& vertex : mesh.vertices) {
    table.add(vertex);
    taken.insert(key_of(vertex.node));
  }
  for (const TileVertex& candidate : candidates) {
    const auto [x, y] = candidate.node;
    const bool is_inside = x > 0 && x < kLastNode && y > 0 && y < kLastNode;
    if (is_inside && taken.insert(key_of(candidate.node)).second) table.add(candidate);
  }
  return table;
}

/// Walks from a triangle to one that holds p; triangles are Delaunay, so that walks end.
std::uint32_t find_from(const PointMesh& mesh, const NodeTable& table, std::uint32_t t,
                        LatticePoint p) {
  for (std::size_t edge = 0; edge < 3;) {
    const LatticeTriangle& triangle = mesh.triangles()[t];
    const LatticePoint from = table.nodes[triangle.corner[edge]];
    const LatticePoint to = table.nodes[triangle.corner[(edge + 1) % 3]];
    if (doubled_area(from, to, p) >= 0) {
      ++edge;
      continue;
    }
    LODE_EXPECTS(triangle.twin[edge] != kNoHalfEdge);
    t = triangle.twin[edge] / 4;
    edge = 0;
  }
  return t;
}

std::vector<std::uint32_t> locate_all(const PointMesh& mesh, const NodeTable& table,
                                      std::size_t first) {
  std::vector<std::uint32_t> triangle_of(table.nodes.size(), kNoHalfEdge);
  std::uint32_t t = 0;
  for (std::size_t i = first; i < table.nodes.size(); ++i) {
    t = find_from(mesh, table, t, table.nodes[i]);
    triangle_of[i] = t;
  }
  return triangle_of;
}

/// The mesh's triangles, and of the table what they use, in its order.
void take_from(const PointMesh& mesh, const NodeTable& table, TileMesh& out) {
  std::vector<std::uint32_t> number(table.nodes.size(), kNoHalfEdge);
  for (const LatticeTriangle& triangle : mesh.triangles())
    for (const std::uint32_t corner : triangle.corner) number[corner] = 0;
  out.vertices.clear();
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == kNoHalfEdge) continue;
    number[i] = static_cast<std::uint32_t>(out.vertices.size());
    out.vertices.push_back({table.nodes[i], table.heights[i]});
  }
  out.triangles.clear();
  out.triangles.reserve(mesh.triangles().size());
  for (const LatticeTriangle& triangle : mesh.triangles())
    out.triangles.push_back(
        {number[triangle.corner[0]], number[triangle.corner[1]], number[triangle.corner[2]]});
}

/// One stage of refine().
Result<std::uint64_t> insert_worst(TileMesh& mesh, std::span<const TileVertex> candidates,
                                   double max_error, Progress& progress) {
  const NodeTable table = to_table(mesh, candidates);
  const std::size_t n_before = mesh.vertices.size();
  if (table.nodes.size() == n_before) return 0;
  PointMesh points(ListedNodes(table.nodes), mesh.triangles);
  const auto triangle_of = locate_all(points, table, n_before);
  const auto [lower, upper] = std::ranges::minmax(table.heights);
  LODE_TRY(const auto report,
           delaunay::insert_points(points, PointSamples{table.nodes, table.heights, triangle_of},
                                   HeightRange{lower, upper}, {.max_error = max_error}, progress));
  if (report.n_inserted > 0) take_from(points, table, mesh);
  return report.n_inserted;
}

/// Every so manyth of a list, scattered over it.
std::vector<TileVertex> part_of(std::span<const TileVertex> candidates, std::uint32_t one_in) {
  std::vector<TileVertex> part;
  part.reserve(candidates.size() / one_in * 2);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const std::uint32_t mixed = static_cast<std::uint32_t>(i) * 0x9E3779B1U;
    if ((mixed >> 16) % one_in == 0) part.push_back(candidates[i]);
  }
  return part;
}

}  // namespace

TileMesh mesh_of_sides(std::span<const TileVertex> sides) {
  NodeTable table;
  for (const LatticePoint corner : {LatticePoint{0, 0}, LatticePoint{kLastNode, 0},
                                    LatticePoint{kLastNode, kLastNode}, LatticePoint{0, kLastNode}})
    table.add(*std::ranges::find(sides, corner, &TileVertex::node));
  for (const TileVertex& vertex : sides) {
    const bool is_corner = vertex.node.x % kLastNode == 0 && vertex.node.y % kLastNode == 0;
    if (!is_corner) table.add(vertex);
  }
  constexpr std::array<std::array<std::uint32_t, 3>, 2> kSquare{{{0, 1, 2}, {0, 2, 3}}};
  PointMesh mesh(ListedNodes(table.nodes), kSquare);
  std::uint32_t t = 0;
  for (std::uint32_t i = 4; i < table.nodes.size(); ++i) {
    t = find_from(mesh, table, t, table.nodes[i]);
    t = mesh.insert(i, t)[0];
  }
  TileMesh out;
  take_from(mesh, table, out);
  return out;
}

void insert_all(TileMesh& mesh, std::span<const TileVertex> vertices) {
  if (vertices.empty()) return;
  NodeTable table;
  for (const TileVertex& vertex : mesh.vertices) table.add(vertex);
  const std::size_t n_before = table.nodes.size();
  for (const TileVertex& vertex : vertices) table.add(vertex);
  PointMesh points(ListedNodes(table.nodes), mesh.triangles);
  std::uint32_t t = 0;
  for (std::size_t i = n_before; i < table.nodes.size(); ++i) {
    t = find_from(points, table, t, table.nodes[i]);
    t = points.insert(static_cast<std::uint32_t>(i), t)[0];
  }
  take_from(points, table, mesh);
}

Result<std::uint64_t> refine(TileMesh& mesh, std::span<const TileVertex> candidates,
                             double max_error, Progress& progress) {
  // While triangles are large, and err by far more than they may, few candidates tell where to
  // refine; then each is in a small one.
  constexpr std::size_t kFew = 128;
  constexpr double kFar = 4;
  std::uint64_t n_inserted = 0;
  for (const std::uint32_t one_in : {256U, 32U, 4U}) {
    if (candidates.size() / one_in < kFew) continue;
    LODE_TRY(const std::uint64_t n,
             insert_worst(mesh, part_of(candidates, one_in), kFar * max_error, progress));
    n_inserted += n;
  }
  LODE_TRY(const std::uint64_t n, insert_worst(mesh, candidates, max_error, progress));
  return n_inserted + n;
}

}  // namespace lode::tile_pyramid
