#include "lode/models/terrain/insertions/history_writer.h"

#include "lode/delaunay/triangle_error.h"

namespace lode::insertions {

using delaunay::LatticePacking;
using delaunay::ListedNodes;
using delaunay::NodeMesh;

Result<History> begin_history(const HeightGrid& grid, const delaunay::GridDomain& domain,
                              Model model) {
  History history;
  history.model = model;
  history.frame = grid;
  history.range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(history.range));
  history.n_samples = domain.n_samples;
  history.n_missing = grid.n_missing();
  history.n_left_out = domain.n_left_out;
  return history;
}

template <typename Nodes>
void HistoryWriter<Nodes>::on_start(const NodeMesh<Nodes>& mesh, std::span<const float> errors) {
  recorder_.start(mesh);
  nodes_.resize(history_.vertices.size());
  for (std::size_t t = 0; t < history_.triangles.size(); ++t) {
    Triangle& triangle = history_.triangles[t];
    triangle.error =
        delaunay::to_coarse_above(errors.empty() ? mesh.triangles()[t].error : errors[t]);
    for (std::size_t i = 0; i < 3; ++i) nodes_[triangle.corner[i]] = mesh.triangles()[t].corner[i];
  }
}

template <typename Nodes>
void HistoryWriter<Nodes>::on_insertion(const NodeMesh<Nodes>& mesh, std::uint32_t node,
                                        std::span<const std::uint32_t> slots, std::size_t n_removed,
                                        std::span<const float> errors) {
  recorder_.add_node(mesh, mesh.nodes().unpack(node), slots, n_removed);
  nodes_.push_back(node);
  const std::size_t first = history_.triangles.size() - slots.size();
  for (std::size_t i = 0; i < slots.size(); ++i)
    history_.triangles[first + i].error =
        delaunay::to_coarse_above(errors.empty() ? mesh.triangles()[slots[i]].error : errors[i]);
}

template class HistoryWriter<LatticePacking>;
template class HistoryWriter<ListedNodes>;

}  // namespace lode::insertions
