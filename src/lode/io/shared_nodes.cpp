#include "lode/io/shared_nodes.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lode/io/cell_shapes.h"
#include "lode/io/polyhedron_faces.h"
#include "lode/io/quadratic_cells.h"

namespace lode::io {
namespace {

constexpr std::uint32_t kNoNode = std::numeric_limits<std::uint32_t>::max();

/// The corners of an edge, or of a face with four, ascending, and the node in its middle.
template <std::size_t N>
struct Shared {
  std::array<std::uint32_t, N> corners{};
  std::uint32_t middle = kNoNode;

  friend auto operator<=>(const Shared&, const Shared&) = default;
};

using SharedEdge = Shared<2>;
using SharedFace = Shared<4>;

/// Sorts them, and takes of those with the same corners and the same node one.
template <std::size_t N>
void keep_different(std::vector<Shared<N>>& all) {
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
}

/// Of different ones, how many have the corners of another, and the first of those.
template <std::size_t N>
std::pair<std::size_t, Shared<N>> find_disagreement(const std::vector<Shared<N>>& different) {
  std::pair<std::size_t, Shared<N>> found;
  for (std::size_t i = 1; i < different.size(); ++i)
    if (different[i].corners == different[i - 1].corners && found.first++ == 0)
      found.second = different[i];
  return found;
}

/// Edges of all solid cells.
std::vector<SharedEdge> list_edges(const CellMesh& mesh) {
  std::vector<SharedEdge> edges;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto nodes = mesh.corners_of(cell);
    const auto type = static_cast<CellType>(mesh.types[cell]);
    const std::span<const Edge> of_type = edges_of(type);
    const std::size_t n_corners = n_corners_of(type);
    const bool has_middles = is_quadratic(mesh, cell);
    for (std::size_t i = 0; i < of_type.size(); ++i) {
      const auto [a, b] = std::minmax(nodes[of_type[i][0]], nodes[of_type[i][1]]);
      if (a != b) edges.push_back({{a, b}, has_middles ? nodes[n_corners + i] : kNoNode});
    }
  }
  keep_different(edges);
  return edges;
}

/// Faces of quadratic cells with four corners that differ.
std::vector<SharedFace> list_faces(const CellMesh& mesh) {
  std::vector<SharedFace> faces;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto shape = quadratic_shape(mesh, cell);
    if (!shape) continue;
    const auto nodes = mesh.corners_of(cell);
    for (const QuadraticFace& face : shape->faces) {
      if (n_corners(face.corners) < 4) continue;
      SharedFace shared;
      if (face.centre) shared.middle = nodes[*face.centre];
      for (std::size_t i = 0; i < 4; ++i) shared.corners[i] = nodes[face.corners[i]];
      std::sort(shared.corners.begin(), shared.corners.end());
      if (std::adjacent_find(shared.corners.begin(), shared.corners.end()) == shared.corners.end())
        faces.push_back(shared);
    }
  }
  keep_different(faces);
  return faces;
}

/// Quadratic faces with four corners of which two across are an edge of another cell, as where that
/// has two triangles.
std::pair<std::size_t, std::array<std::uint32_t, 2>> find_cut_faces(
    const CellMesh& mesh, const std::vector<SharedEdge>& edges) {
  std::pair<std::size_t, std::array<std::uint32_t, 2>> found;
  const auto is_edge = [&](std::uint32_t a, std::uint32_t b) {
    const std::array<std::uint32_t, 2> ends = {std::min(a, b), std::max(a, b)};
    const auto at = std::lower_bound(edges.begin(), edges.end(), SharedEdge{ends, 0});
    if (a == b || at == edges.end() || at->corners != ends) return false;
    if (found.first++ == 0) found.second = ends;
    return true;
  };
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto shape = quadratic_shape(mesh, cell);
    if (!shape) continue;
    const auto nodes = mesh.corners_of(cell);
    for (const auto& [corners, middles, centre] : shape->faces) {
      if (n_corners(corners) < 4) continue;
      const std::array<std::uint32_t, 4> c = {nodes[corners[0]], nodes[corners[1]],
                                              nodes[corners[2]], nodes[corners[3]]};
      if (c[0] == c[1] || c[1] == c[2] || c[2] == c[3] || c[3] == c[0]) continue;
      [[maybe_unused]] const bool is_cut = is_edge(c[0], c[2]) || is_edge(c[1], c[3]);
    }
  }
  return found;
}

/// Quadratic cells with a point that a polyhedron has.
std::size_t count_beside_polyhedra(const CellMesh& mesh) {
  if (mesh.face_begins.empty()) return 0;
  std::vector<bool> is_polyhedrons(mesh.points.size());
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    if (static_cast<CellType>(mesh.types[cell]) == CellType::polyhedron)
      for (const std::uint32_t corner : distinct_corners(mesh, cell)) is_polyhedrons[corner] = true;
  std::size_t n = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto nodes = mesh.corners_of(cell);
    const auto is_shared = [&](std::uint32_t node) { return is_polyhedrons[node]; };
    if (is_quadratic(mesh, cell) && std::any_of(nodes.begin(), nodes.end(), is_shared)) ++n;
  }
  return n;
}

}  // namespace

Result<void> check_shared_nodes(const CellMesh& mesh) {
  constexpr const char* kAdvice = "linearised to their corners (--linearise corners) they meet";
  bool has_quadratic = false;
  for (std::size_t cell = 0; cell < mesh.n_cells() && !has_quadratic; ++cell)
    has_quadratic = is_quadratic(mesh, cell);
  if (!has_quadratic) return {};
  if (const std::size_t n = count_beside_polyhedra(mesh); n > 0)
    return fail(
        "{}: expected quadratic cells that do not touch polyhedra, whose faces would not meet "
        "theirs, got {} that do: {}",
        mesh.path, n, kAdvice);
  const std::vector<SharedEdge> edges = list_edges(mesh);
  if (const auto [n, first] = find_disagreement(edges); n > 0)
    return fail(
        "{}: expected cells at an edge to have the same node in its middle, or none, got {} edges "
        "where they have not, the first between points {} and {}: {}, and nodes at one place may "
        "be welded (--weld 0)",
        mesh.path, n, first.corners[0], first.corners[1], kAdvice);
  if (const auto [n, first] = find_disagreement(list_faces(mesh)); n > 0)
    return fail(
        "{}: expected both cells at a face to have the same node in its middle, or none, got {} "
        "faces where they have not, the first at points {}: {}",
        mesh.path, n, fmt::join(first.corners, ", "), kAdvice);
  if (const auto [n, ends] = find_cut_faces(mesh, edges); n > 0)
    return fail(
        "{}: expected faces of quadratic cells with four corners to meet such faces, got {} of "
        "which two corners are another cell's edge, the first points {} and {}: {}",
        mesh.path, n, ends[0], ends[1], kAdvice);
  return {};
}

}  // namespace lode::io
