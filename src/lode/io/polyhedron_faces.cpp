#include "lode/io/polyhedron_faces.h"

#include <algorithm>
#include <utility>

#include "lode/io/polygon_triangles.h"

namespace lode::io {
namespace {

using Loop = std::vector<std::uint32_t>;

/// A side of a face; from its smaller to its larger point, or back.
struct FaceEdge {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t face = 0;
  bool rises = true;

  [[nodiscard]] bool is_at(const FaceEdge& other) const {
    return low == other.low && high == other.high;
  }
};

/// The faces without points that follow themselves, as welded ones may; of three points or more.
std::vector<Loop> loops_of(const CellMesh& mesh, std::size_t cell) {
  std::vector<Loop> loops;
  const auto faces = mesh.faces_of(cell);
  for (std::size_t at = 0; at < faces.size(); at += faces[at] + std::size_t{1}) {
    Loop loop;
    for (const std::uint32_t id : faces.subspan(at + 1, faces[at]))
      if (loop.empty() || loop.back() != id) loop.push_back(id);
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

/// In the order of their points.
std::vector<FaceEdge> edges_of(const std::vector<Loop>& loops) {
  std::vector<FaceEdge> edges;
  for (std::size_t face = 0; face < loops.size(); ++face)
    for (std::size_t i = 0; i < loops[face].size(); ++i) {
      const std::uint32_t a = loops[face][i];
      const std::uint32_t b = loops[face][(i + 1) % loops[face].size()];
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(face), a < b});
    }
  std::stable_sort(edges.begin(), edges.end(), [](const FaceEdge& a, const FaceEdge& b) {
    return std::pair(a.low, a.high) < std::pair(b.low, b.high);
  });
  return edges;
}

/// A face next to another one, and whether the two are wound alike.
struct FaceNeighbour {
  std::uint32_t face = 0;
  bool agrees = true;
};

using FaceNeighbours = std::vector<std::vector<FaceNeighbour>>;

Result<FaceNeighbours> neighbours_of(const CellMesh& mesh, std::size_t cell,
                                     const std::vector<Loop>& loops) {
  const std::vector<FaceEdge> edges = edges_of(loops);
  FaceNeighbours neighbours(loops.size());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].is_at(edges[i])) ++end;
    if (end - i != 2)
      return fail("{}: expected closed polyhedra, got {} faces at the edge {} {} of cell {}",
                  mesh.path, end - i, edges[i].low, edges[i].high, cell);
    const bool agrees = edges[i].rises != edges[i + 1].rises;
    neighbours[edges[i].face].push_back({edges[i + 1].face, agrees});
    neighbours[edges[i + 1].face].push_back({edges[i].face, agrees});
    i = end;
  }
  return neighbours;
}

/// Turns loops round until all are wound like the first one.
Result<void> make_agree(const CellMesh& mesh, std::size_t cell, std::vector<Loop>& loops) {
  LODE_TRY(const FaceNeighbours neighbours, neighbours_of(mesh, cell, loops));
  enum class Winding : std::uint8_t { unknown, kept, turned };
  std::vector<Winding> windings(loops.size(), Winding::unknown);
  std::vector<std::uint32_t> found{0};
  if (!loops.empty()) windings[0] = Winding::kept;
  for (std::size_t i = 0; i < found.size() && !loops.empty(); ++i)
    for (const FaceNeighbour& next : neighbours[found[i]]) {
      const bool is_turned = (windings[found[i]] == Winding::turned) == next.agrees;
      const Winding winding = is_turned ? Winding::turned : Winding::kept;
      if (windings[next.face] == Winding::unknown) {
        windings[next.face] = winding;
        found.push_back(next.face);
      } else if (windings[next.face] != winding) {
        return fail("{}: expected polyhedra that have an inside, got a one-sided cell {}",
                    mesh.path, cell);
      }
    }
  if (found.size() < loops.size())
    return fail("{}: expected polyhedra of connected faces, got {} of {} connected in cell {}",
                mesh.path, found.size(), loops.size(), cell);
  for (std::size_t face = 0; face < loops.size(); ++face)
    if (windings[face] == Winding::turned) std::reverse(loops[face].begin(), loops[face].end());
  return {};
}

}  // namespace

std::vector<std::uint32_t> distinct_corners(const CellMesh& mesh, std::size_t cell) {
  std::vector<std::uint32_t> distinct;
  const auto faces = mesh.faces_of(cell);
  for (std::size_t at = 0; at < faces.size(); at += faces[at] + std::size_t{1})
    for (const std::uint32_t id : faces.subspan(at + 1, faces[at])) distinct.push_back(id);
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  return distinct;
}

Vec3d mean_position(const CellMesh& mesh, std::span<const std::uint32_t> corners) {
  Vec3d sum;
  for (const std::uint32_t corner : corners) sum = sum + mesh.points[corner];
  return sum * (1.0 / static_cast<double>(corners.size()));
}

Result<std::vector<std::array<std::uint32_t, 3>>> outward_triangles(const CellMesh& mesh,
                                                                    std::size_t cell) {
  std::vector<Loop> loops = loops_of(mesh, cell);
  LODE_CHECK(make_agree(mesh, cell, loops));
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const Loop& loop : loops) {
    const auto more = polygon_triangles(mesh.points, loop);
    triangles.insert(triangles.end(), more.begin(), more.end());
  }
  const Vec3d centre = mean_position(mesh, distinct_corners(mesh, cell));
  double volume = 0;
  for (const auto& [a, b, c] : triangles)
    volume += dot(cross(mesh.points[a] - centre, mesh.points[b] - centre), mesh.points[c] - centre);
  if (volume < 0)
    for (auto& triangle : triangles) std::swap(triangle[1], triangle[2]);
  return triangles;
}

}  // namespace lode::io
