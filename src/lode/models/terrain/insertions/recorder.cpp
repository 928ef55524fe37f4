#include "lode/models/terrain/insertions/recorder.h"

#include <algorithm>
#include <unordered_map>

namespace lode::insertions {

using delaunay::LatticePacking;
using delaunay::LatticePoint;
using delaunay::LatticeTriangle;
using delaunay::ListedNodes;
using delaunay::NodeMesh;

template <typename Nodes>
void Recorder::start(const NodeMesh<Nodes>& mesh) {
  std::unordered_map<std::uint32_t, std::uint32_t> vertex_of;
  for (const LatticeTriangle& triangle : mesh.triangles()) {
    Triangle made{.corner = {}, .death = kNone, .error = 0};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto next = static_cast<std::uint32_t>(history_.vertices.size());
      const auto [at, is_new] = vertex_of.try_emplace(triangle.corner[i], next);
      if (is_new) history_.vertices.push_back(mesh.nodes().unpack(triangle.corner[i]));
      made.corner[i] = at->second;
    }
    current_.push_back(static_cast<std::uint32_t>(history_.triangles.size()));
    history_.triangles.push_back(made);
  }
  history_.n_base_vertices = static_cast<std::uint32_t>(history_.vertices.size());
}

template <typename Nodes>
void Recorder::add_node(const NodeMesh<Nodes>& mesh, LatticePoint at,
                        std::span<const std::uint32_t> slots, std::size_t n_removed) {
  const std::uint32_t node = history_.n_nodes();
  const auto vertex = static_cast<std::uint32_t>(history_.vertices.size());
  history_.vertices.push_back(at);
  border_.clear();
  for (const std::uint32_t slot : slots.first(n_removed)) {
    Triangle& gone = history_.triangles[current_[slot]];
    gone.death = node;
    history_.removed.push_back(current_[slot]);
    border_.insert(border_.end(), gone.corner.begin(), gone.corner.end());
  }
  history_.first_removed.push_back(static_cast<std::uint32_t>(history_.removed.size()));
  history_.first_made.push_back(static_cast<std::uint32_t>(history_.triangles.size()));
  current_.resize(mesh.triangles().size());
  for (const std::uint32_t slot : slots) {
    const LatticeTriangle& triangle = mesh.triangles()[slot];
    current_[slot] = static_cast<std::uint32_t>(history_.triangles.size());
    history_.triangles.push_back({{border_vertex(mesh.nodes().unpack(triangle.corner[0])),
                                   border_vertex(mesh.nodes().unpack(triangle.corner[1])), vertex},
                                  kNone,
                                  0});
  }
}

std::uint32_t Recorder::border_vertex(LatticePoint p) const {
  return *std::ranges::find_if(
      border_, [&](std::uint32_t vertex) { return history_.vertices[vertex] == p; });
}

void Recorder::finish() {
  history_.first_made.push_back(static_cast<std::uint32_t>(history_.triangles.size()));
}

template void Recorder::start(const NodeMesh<LatticePacking>&);
template void Recorder::start(const NodeMesh<ListedNodes>&);
template void Recorder::add_node(const NodeMesh<LatticePacking>&, LatticePoint,
                                 std::span<const std::uint32_t>, std::size_t);
template void Recorder::add_node(const NodeMesh<ListedNodes>&, LatticePoint,
                                 std::span<const std::uint32_t>, std::size_t);

}  // namespace lode::insertions
