#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// Writes down what happens to a mesh: vertices, triangles and deaths, neither heights nor errors.
class Recorder {
 public:
  /// The history is empty but for what it knows of the grid, and outlives it.
  explicit Recorder(History& history) : history_(history) { history_.first_removed = {0}; }

  /// The base, in the order of its slots.
  template <typename Nodes>
  void start(const delaunay::NodeMesh<Nodes>& mesh);
  /// As MeshObserver::on_insertion(): the next node; its triangles are in the order of the slots.
  template <typename Nodes>
  void add_node(const delaunay::NodeMesh<Nodes>& mesh, delaunay::LatticePoint at,
                std::span<const std::uint32_t> slots, std::size_t n_removed);
  /// When all nodes are there.
  void finish();

  /// What is in a slot of the mesh.
  [[nodiscard]] std::uint32_t triangle_in(std::uint32_t slot) const { return current_[slot]; }

 private:
  [[nodiscard]] std::uint32_t border_vertex(delaunay::LatticePoint p) const;

  History& history_;
  std::vector<std::uint32_t> current_;  ///< By slot of the mesh, the triangle there.
  std::vector<std::uint32_t> border_;   ///< Corners of what the node removes.
};

}  // namespace lode::insertions
