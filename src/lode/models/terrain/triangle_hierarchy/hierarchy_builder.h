#pragma once

#include <span>
#include <utility>
#include <vector>

#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode::triangle_hierarchy {

/// Each finite, >= 0 and smaller than the one before; at least one.
[[nodiscard]] Result<void> check_tolerances(std::span<const double> tolerances);

/// Puts a hierarchy together, level by level.
class HierarchyBuilder {
 public:
  /// A triangle to be added.
  struct Made {
    std::uint32_t refined = kNone;  ///< The triangle that it is part of; of level 0 none.
    std::array<std::uint32_t, 3> corner;
    double sample_error = 0;
    double error = 0;  ///< With its edges: what a later level looks at.
  };

  /// The surface must outlive this.
  explicit HierarchyBuilder(const ReferenceSurface& surface);

  [[nodiscard]] const ReferenceSurface& surface() const { return surface_; }
  /// Moves: how often the place, or one of those that it hangs on, has been moved onto the lattice.
  std::uint32_t add_vertex(const Place& place, std::int32_t n_moves);
  [[nodiscard]] std::size_t n_vertices() const { return made_.vertices.size(); }
  [[nodiscard]] std::int32_t n_moves(std::uint32_t vertex) const { return n_moves_[vertex]; }
  [[nodiscard]] Place place(std::uint32_t vertex) const {
    return {made_.vertices[vertex], made_.heights[vertex]};
  }
  [[nodiscard]] std::array<Place, 3> places(const std::array<std::uint32_t, 3>& corner) const {
    return {place(corner[0]), place(corner[1]), place(corner[2])};
  }

  /// The triangles of the mesh so far, by their numbers, and what they look like.
  [[nodiscard]] std::span<const std::uint32_t> mesh() const { return mesh_; }
  [[nodiscard]] const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const {
    return made_.triangles[triangle].corner;
  }
  [[nodiscard]] double error(std::uint32_t triangle) const { return errors_[triangle]; }

  /// A level within a tolerance of what was made, sorted by the triangles that are refined; in
  /// level 0 all. Fails where there are too many triangles.
  [[nodiscard]] Result<void> add_level(double tolerance, std::span<const Made> made);
  [[nodiscard]] Hierarchy finish();

 private:
  void refine_mesh(std::uint32_t first);
  void link(std::uint32_t first);

  const ReferenceSurface& surface_;
  Hierarchy made_;
  std::vector<std::int32_t> n_moves_;  ///< By vertex.
  std::vector<double> errors_;         ///< By triangle.
  std::vector<std::uint32_t> mesh_;
};

}  // namespace lode::triangle_hierarchy
