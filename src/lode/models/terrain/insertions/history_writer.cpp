#include "lode/models/terrain/insertions/history_writer.h"

#include "lode/delaunay/triangle_error.h"

namespace lode::insertions {

using delaunay::LatticeMesh;

Result<History> HistoryWriter::begin(const HeightGrid& grid, const delaunay::GridDomain& domain,
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

void HistoryWriter::on_start(const LatticeMesh& mesh) {
  recorder_.start(mesh);
  for (std::size_t t = 0; t < history_.triangles.size(); ++t)
    history_.triangles[t].error = delaunay::to_coarse_above(mesh.triangles()[t].error);
}

void HistoryWriter::on_insertion(const LatticeMesh& mesh, std::uint32_t node,
                                 std::span<const std::uint32_t> slots, std::size_t n_removed) {
  recorder_.add_node(mesh, mesh.nodes().unpack(node), slots, n_removed);
  std::size_t t = history_.triangles.size() - slots.size();
  for (const std::uint32_t slot : slots)
    history_.triangles[t++].error = delaunay::to_coarse_above(mesh.triangles()[slot].error);
}

void HistoryWriter::finish(const HeightGrid& grid) {
  recorder_.finish();
  history_.heights.reserve(history_.vertices.size());
  for (const delaunay::LatticePoint& p : history_.vertices)
    history_.heights.push_back(grid.height(p.x, p.y));
}

}  // namespace lode::insertions
