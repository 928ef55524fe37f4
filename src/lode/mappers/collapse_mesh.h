#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/surface.h"
#include "lode/core/uninitialized_array.h"
#include "lode/core/vec.h"

namespace lode::simplification {

inline constexpr std::uint32_t kNone = 0xFFFFFFFFU;
inline constexpr std::uint32_t kDead = 0xFFFFFFFEU;

/// A triangle of the surface being simplified, and the original vertices attached to it: a list
/// through CollapseMesh::next_point.
struct WorkTriangle {
  std::array<std::uint32_t, 3> v;
  std::uint32_t points = kNone;  ///< The first of the list; kDead: a collapse took the triangle.

  [[nodiscard]] bool is_dead() const { return points == kDead; }
};

/// An edge collapse, with what undoing it takes. The removed vertex keeps its position; corners of
/// dead triangles mean nothing.
struct Collapse {
  std::uint32_t kept;
  std::uint32_t removed;
  std::array<std::uint32_t, 2> dead;   ///< One of them at an edge of the border: the other kNone.
  std::array<float, 3> kept_position;  ///< Before.
  std::uint32_t last_kept;             ///< What CollapseMesh::last was before.
  std::uint32_t last_removed;
};

/// A surface while its edges are collapsed. Vertices and triangles keep their numbers.
struct CollapseMesh {
  UninitializedArray<Vec3f> positions;
  UninitializedArray<WorkTriangle> triangles;
  UninitializedArray<std::uint32_t> next_point;   ///< By original vertex.
  UninitializedArray<std::uint32_t> attached_to;  ///< By original vertex: the triangle.
  UninitializedArray<std::uint32_t> last;         ///< By vertex: its last collapse, or kNone.
  /// Later ones have higher numbers where they have a vertex in common; numbers have gaps.
  UninitializedArray<Collapse> collapses;

  [[nodiscard]] bool is_removed(std::uint32_t v) const {
    return last[v] != kNone && collapses[last[v]].removed == v;
  }
  /// The vertex that v has gone into.
  [[nodiscard]] std::uint32_t root_of(std::uint32_t v) const {
    while (is_removed(v)) v = collapses[last[v]].kept;
    return v;
  }
};

/// Of a surface's triangles, of which there is one: of about 100,000 of them.
[[nodiscard]] double mean_area(const Surface& surface);
/// That nothing has collapsed in, and no vertex is attached in. O(n).
[[nodiscard]] CollapseMesh make_mesh(const Surface& surface, Threads threads);
/// Attaches vertices of triangles that are attached to none yet: to the first of these.
void attach_rest(std::span<const std::uint32_t> triangles, CollapseMesh& mesh);

[[nodiscard]] inline std::array<Vec3f, 3> corners(const CollapseMesh& mesh,
                                                  std::uint32_t triangle) {
  const WorkTriangle& t = mesh.triangles[triangle];
  return {mesh.positions[t.v[0]], mesh.positions[t.v[1]], mesh.positions[t.v[2]]};
}

/// Original triangles round original vertices.
struct Surroundings {
  std::span<const std::uint32_t> first;  ///< By vertex, and one more.
  std::span<const std::uint32_t> triangles;

  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t v) const {
    return triangles.subspan(first[v], first[v + 1] - first[v]);
  }
};

/// Lower and upper corner of the box round some points, at least one.
template <typename Points>
[[nodiscard]] std::array<Vec3f, 2> bounds_of(const Points& points) {
  std::array<Vec3f, 2> box{points.front(), points.front()};
  for (const Vec3f& p : points)
    for (std::size_t i = 0; i < 3; ++i) {
      box[0][i] = std::min(box[0][i], p[i]);
      box[1][i] = std::max(box[1][i], p[i]);
    }
  return box;
}

/// Numbers below n that are to be taken, ascending.
template <typename Take>
[[nodiscard]] std::vector<std::uint32_t> numbers_where(std::size_t n, Threads threads,
                                                       const Take& take) {
  constexpr std::size_t kPiece = 1 << 16;
  std::vector<std::vector<std::uint32_t>> pieces((n + kPiece - 1) / kPiece);
  parallel_for(pieces.size(), threads, 1, [&](std::size_t piece, int) {
    for (std::size_t i = piece * kPiece; i < std::min(n, (piece + 1) * kPiece); ++i)
      if (take(static_cast<std::uint32_t>(i)))
        pieces[piece].push_back(static_cast<std::uint32_t>(i));
  });
  std::vector<std::uint32_t> found;
  for (const auto& piece : pieces) found.insert(found.end(), piece.begin(), piece.end());
  return found;
}

/// Triangles that are there, ascending.
[[nodiscard]] inline std::vector<std::uint32_t> live_triangles(const CollapseMesh& mesh,
                                                               Threads threads) {
  return numbers_where(mesh.triangles.size(), threads,
                       [&](std::uint32_t t) { return !mesh.triangles[t].is_dead(); });
}

inline void sort_unique(std::vector<std::uint32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace lode::simplification
