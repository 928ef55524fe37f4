#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode::triangle_hierarchy {

using delaunay::LatticePoint;

inline constexpr std::uint32_t kNone = 0xFFFFFFFF;

/// Triangles refined into triangulations (L. De Floriani, P. Marzano, E. Puppo, "Multiresolution
/// models for topographic surface description", The Visual Computer 12 (1996), sections 4 and 5: a
/// hierarchical subdivision with explicit multiresolution). Level 0 is a triangulation of the
/// domain within the first tolerance; at each further level every triangle of the mesh that errs by
/// more than its tolerance is replaced by a triangulation of its own, of at least two triangles.
/// The mesh of a level is of the triangles made until then and not replaced; meshes of all levels
/// conform and cover the domain once. Made by HierarchyBuilder.
struct Hierarchy {
  struct Triangle {
    std::array<std::uint32_t, 3> corner;  ///< Vertices, turning left (x to the right, y up).
    /// Behind the edge from corner i to corner i + 1, in the mesh of the level that made this: 4
    /// times that triangle and its edge, or delaunay::kNoHalfEdge.
    std::array<std::uint32_t, 3> twin;
    std::uint32_t refinement = kNone;
    float error = 0;  ///< No sample in it errs by more.
  };
  /// What replaces a triangle.
  struct Refinement {
    std::uint32_t triangle = 0;
    std::uint32_t first = 0;  ///< Its triangles follow one another up to the next refinement's.
  };

  HeightFrame frame;
  /// Of scattered points, or of a raster with breaklines: any nodes of the frame's lattice may be
  /// samples, and the outline goes from one to another. Else each one of the domain is a sample.
  bool is_of_points = false;
  int bits = 0;                    ///< Columns and rows are 2^bits nodes of the lattice apart.
  std::vector<double> tolerances;  ///< Of the levels, each smaller than the one before.
  /// Nodes of the fine lattice, in the order of levels; what levels share they share as numbers.
  std::vector<LatticePoint> vertices;
  std::vector<double> heights;
  std::vector<std::uint32_t> in_rows;  ///< All vertices, as they lie in rows.
  std::vector<Triangle> triangles;     ///< By levels, and there by refinements.
  std::vector<Refinement> refinements;
  /// From vertex to vertex of level 0, both samples; of a raster along rows, columns or diagonals,
  /// of points along edges of the triangulation of all: in every level's mesh each is an edge, or a
  /// chain of edges on it.
  std::vector<std::array<std::uint32_t, 2>> lines;
  /// Of points: those refined triangles that have some close beside them, so that what refines them
  /// may have come to lie over these: find_crowded(). Of rasters none, as it is known where samples
  /// are.
  std::vector<std::uint32_t> crowded;
  /// How many of each there are up to a level, that with it.
  std::vector<std::uint32_t> vertices_until;
  std::vector<std::uint32_t> triangles_until;
  /// How far triangles may reach out of those that they refine, in nodes: see the document.
  std::int32_t reach = 0;

  [[nodiscard]] std::int32_t scale() const { return std::int32_t{1} << bits; }
  [[nodiscard]] int n_levels() const { return static_cast<int>(tolerances.size()); }
  [[nodiscard]] std::uint64_t n_bytes() const;
  /// The numbers of a refinement's triangles: the first, and one past the last.
  [[nodiscard]] std::array<std::uint32_t, 2> triangles_of(std::uint32_t refinement) const;
  /// Whether a triangle made until then is in the mesh of a level.
  [[nodiscard]] bool is_in_level(std::uint32_t triangle, int level) const {
    const std::uint32_t refinement = triangles[triangle].refinement;
    return refinement == kNone ||
           refinements[refinement].first >= triangles_until[static_cast<std::size_t>(level)];
  }
  /// Triangles in the mesh of a level. O(log refinements).
  [[nodiscard]] std::uint64_t n_triangles_in(int level) const;
  /// The first level within a tolerance. Fails where it is below the last one's.
  [[nodiscard]] Result<int> level_within(double tolerance) const;
  /// What is behind an edge of a triangle in the mesh of its level, or of a later one; kNoHalfEdge:
  /// nothing. O(triangles of the refinements passed).
  [[nodiscard]] std::uint32_t neighbour(int level, std::uint32_t triangle, unsigned edge) const;
};

/// The mesh of a level, on the fine lattice: vertices in rows with heights, triangles as they were
/// made, with twins and errors if `links` says so. O(triangles until that level), which are fewer
/// than twice the mesh's, O(vertices), and O(n log n) for twins.
[[nodiscard]] delaunay::Tin tin_of_level(const Hierarchy& hierarchy, int level,
                                         delaunay::TinLinks links);

/// Refinements with triangles, or what these are refined by, whose bounds lie further out of those
/// of the triangle than `reach`.
[[nodiscard]] std::uint64_t n_out_of_reach(const Hierarchy& hierarchy);

/// Gives a TIN's triangles, whose corners are numbers of vertices, its own vertices, in rows.
void place_vertices(const Hierarchy& hierarchy, delaunay::Tin& tin);

}  // namespace lode::triangle_hierarchy
