#include "lode/io/shared_nodes.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "lode/io/cell_shapes.h"
#include "lode/io/polyhedron_faces.h"
#include "lode/io/quadratic_cells.h"

namespace lode::io {
namespace {

constexpr std::uint32_t kNoNode = std::numeric_limits<std::uint32_t>::max();

/// An edge of a solid cell, its corners ascending.
struct SharedEdge {
  std::array<std::uint32_t, 2> corners{};
  bool has_middle = false;  ///< A node that is none of these.

  friend auto operator<=>(const SharedEdge&, const SharedEdge&) = default;
};

/// A face of a quadratic cell.
struct SharedFace {
  std::array<std::uint32_t, 4> corners{};  ///< Ascending, of triangles the largest twice.
  std::uint32_t cell = 0;
  std::uint8_t face = 0;

  friend auto operator<=>(const SharedFace&, const SharedFace&) = default;
};

/// Edges of all solid cells, each once with a node in its middle and once without.
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
      if (a == b) continue;
      const std::uint32_t middle = has_middles ? nodes[n_corners + i] : a;
      edges.push_back({{a, b}, middle != a && middle != b});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Edges that have a node in the middle for some cells alone, and the first of them.
std::pair<std::size_t, SharedEdge> find_bare_edges(const std::vector<SharedEdge>& edges) {
  std::pair<std::size_t, SharedEdge> found;
  for (std::size_t i = 1; i < edges.size(); ++i)
    if (edges[i].corners == edges[i - 1].corners && found.first++ == 0) found.second = edges[i];
  return found;
}

/// The faces of a quadratic tetrahedron, with the nodes of their edges.
constexpr std::array<QuadraticFace, 4> kTetrahedronOf10 = {
    {{.corners = {0, 1, 3, 3}, .middles = {4, 8, 7}},
     {.corners = {1, 2, 3, 3}, .middles = {5, 9, 8}},
     {.corners = {2, 0, 3, 3}, .middles = {6, 7, 9}},
     {.corners = {0, 2, 1, 1}, .middles = {6, 5, 4}}}};

std::span<const QuadraticFace> quadratic_faces(const CellMesh& mesh, std::size_t cell) {
  if (const auto shape = quadratic_shape(mesh, cell)) return shape->faces;
  if (static_cast<CellType>(mesh.types[cell]) == CellType::quadratic_tetrahedron)
    return kTetrahedronOf10;
  return {};
}

/// Of quadratic cells, where their corners differ.
std::vector<SharedFace> list_faces(const CellMesh& mesh) {
  std::vector<SharedFace> all;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const auto nodes = mesh.corners_of(cell);
    const std::span<const QuadraticFace> faces = quadratic_faces(mesh, cell);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      SharedFace shared{.cell = static_cast<std::uint32_t>(cell),
                        .face = static_cast<std::uint8_t>(f)};
      const std::size_t n = n_corners(faces[f].corners);
      for (std::size_t i = 0; i < n; ++i) shared.corners[i] = nodes[faces[f].corners[i]];
      const auto end = shared.corners.begin() + static_cast<std::ptrdiff_t>(n);
      std::sort(shared.corners.begin(), end);
      if (std::adjacent_find(shared.corners.begin(), end) != end) continue;
      if (n == 3) shared.corners[3] = shared.corners[2];
      all.push_back(shared);
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// The nodes in the middles of a face's edges, by the edges' corners, then that in its own; kNoNode
/// where there is none.
std::array<std::uint32_t, 5> middles_of(const CellMesh& mesh, const SharedFace& shared) {
  const QuadraticFace& face = quadratic_faces(mesh, shared.cell)[shared.face];
  const auto nodes = mesh.corners_of(shared.cell);
  const std::size_t n = n_corners(face.corners);
  std::array<std::array<std::uint32_t, 3>, 4> by_edge{};
  for (std::size_t i = 0; i < n; ++i) {
    const auto [a, b] = std::minmax(nodes[face.corners[i]], nodes[face.corners[(i + 1) % n]]);
    by_edge[i] = {a, b, nodes[face.middles[i]]};
  }
  std::sort(by_edge.begin(), by_edge.begin() + static_cast<std::ptrdiff_t>(n));
  std::array<std::uint32_t, 5> middles{};
  middles.fill(kNoNode);
  for (std::size_t i = 0; i < n; ++i) middles[i] = by_edge[i][2];
  if (face.centre) middles[4] = nodes[*face.centre];
  return middles;
}

/// How the nodes of two cells' faces with the same corners differ.
enum class Difference { none, lacking, elsewhere, doubled };

Difference difference_of(const CellMesh& mesh, const SharedFace& a, const SharedFace& b) {
  const std::array<std::uint32_t, 5> of_a = middles_of(mesh, a);
  const std::array<std::uint32_t, 5> of_b = middles_of(mesh, b);
  if (of_a == of_b) return Difference::none;
  Difference found = Difference::doubled;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (of_a[i] == of_b[i]) continue;
    if (of_a[i] == kNoNode || of_b[i] == kNoNode) return Difference::lacking;
    if (mesh.points[of_a[i]] != mesh.points[of_b[i]]) found = Difference::elsewhere;
  }
  return found;
}

/// How many neighbouring faces differ in some way, and the first of them.
struct FaceDifferences {
  std::array<std::size_t, 4> n{};
  std::array<SharedFace, 4> first{};

  [[nodiscard]] std::size_t count(Difference how) const { return n[static_cast<std::size_t>(how)]; }
  [[nodiscard]] const std::array<std::uint32_t, 4>& corners(Difference how) const {
    return first[static_cast<std::size_t>(how)].corners;
  }
};

FaceDifferences find_differences(const CellMesh& mesh) {
  const std::vector<SharedFace> faces = list_faces(mesh);
  FaceDifferences found;
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].corners != faces[i - 1].corners) continue;
    const auto how = static_cast<std::size_t>(difference_of(mesh, faces[i - 1], faces[i]));
    if (found.n[how]++ == 0) found.first[how] = faces[i];
  }
  return found;
}

/// Quadratic faces with four corners of which two across are an edge of another cell, as where that
/// has two triangles; and the first such edge.
std::pair<std::size_t, std::array<std::uint32_t, 2>> find_cut_faces(
    const CellMesh& mesh, const std::vector<SharedEdge>& edges) {
  std::pair<std::size_t, std::array<std::uint32_t, 2>> found;
  const auto look_at = [&](std::uint32_t a, std::uint32_t b) {
    const std::array<std::uint32_t, 2> ends = {std::min(a, b), std::max(a, b)};
    const auto at = std::lower_bound(edges.begin(), edges.end(), SharedEdge{ends, false});
    if (a == b || at == edges.end() || at->corners != ends) return;
    if (found.first++ == 0) found.second = ends;
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
      look_at(c[0], c[2]);
      look_at(c[1], c[3]);
    }
  }
  return found;
}

/// Quadratic cells with points that a polyhedron has, two at least, as of an edge.
std::size_t count_beside_polyhedra(const CellMesh& mesh) {
  if (mesh.face_begins.empty()) return 0;
  std::vector<bool> is_polyhedrons(mesh.points.size());
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    if (static_cast<CellType>(mesh.types[cell]) == CellType::polyhedron)
      for (const std::uint32_t corner : distinct_corners(mesh, cell)) is_polyhedrons[corner] = true;
  std::size_t n = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    if (!is_quadratic(mesh, cell)) continue;
    std::set<std::uint32_t> shared;
    for (const std::uint32_t node : mesh.corners_of(cell))
      if (is_polyhedrons[node]) shared.insert(node);
    if (shared.size() > 1) ++n;
  }
  return n;
}

}  // namespace

Result<std::uint64_t> check_shared_nodes(const CellMesh& mesh) {
  constexpr const char* kAdvice = "linearised to their corners (--linearise corners) they meet";
  bool has_quadratic = false;
  for (std::size_t cell = 0; cell < mesh.n_cells() && !has_quadratic; ++cell)
    has_quadratic = is_quadratic(mesh, cell);
  if (!has_quadratic) return 0;
  if (const std::size_t n = count_beside_polyhedra(mesh); n > 0)
    return fail(
        "{}: expected quadratic cells that share no edge with polyhedra, whose faces would not "
        "meet theirs, got {} that do: {}",
        mesh.path, n, kAdvice);
  const std::vector<SharedEdge> edges = list_edges(mesh);
  if (const auto [n, first] = find_bare_edges(edges); n > 0)
    return fail(
        "{}: expected all cells at an edge to have a node in its middle, or none, got {} edges "
        "where some have, the first between points {} and {}: {}",
        mesh.path, n, first.corners[0], first.corners[1], kAdvice);
  if (const auto [n, ends] = find_cut_faces(mesh, edges); n > 0)
    return fail(
        "{}: expected faces of quadratic cells with four corners to meet such faces, got {} of "
        "which two corners are another cell's edge, the first points {} and {}: {}",
        mesh.path, n, ends[0], ends[1], kAdvice);
  const FaceDifferences found = find_differences(mesh);
  if (const std::size_t n = found.count(Difference::lacking); n > 0)
    return fail(
        "{}: expected both cells at a face to have a node in its middle, or neither, got {} faces "
        "of which one has, the first at points {}: {}",
        mesh.path, n, fmt::join(found.corners(Difference::lacking), ", "), kAdvice);
  if (const std::size_t n = found.count(Difference::doubled); n > 0)
    return fail(
        "{}: expected both cells at a face to have the same nodes in the middles of its edges, got "
        "{} faces with two at one place, the first at points {}: --weld 0, with --weld-values "
        "where values differ, makes them one",
        mesh.path, n, fmt::join(found.corners(Difference::doubled), ", "));
  return found.count(Difference::elsewhere);
}

}  // namespace lode::io
