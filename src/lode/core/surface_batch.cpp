#include "lode/core/surface_batch.h"

namespace lode {

void SurfaceMirror::apply(const SurfaceBatch& batch) {
  if (batch.starts_over) clear();
  origin_ = batch.origin;
  positions_.resize(batch.n_vertex_slots);
  if (!batch.normals.empty() || !normals_.empty()) normals_.resize(batch.n_vertex_slots);
  cells_.resize(batch.n_cell_slots, SurfaceBatch::kRemoved);
  for (std::size_t i = 0; i < batch.vertices.size(); ++i) {
    positions_[batch.vertices[i]] = batch.positions[i];
    if (!batch.normals.empty()) normals_[batch.vertices[i]] = batch.normals[i];
  }
  for (std::size_t i = 0; i < batch.cells.size(); ++i) {
    SurfaceBatch::Cell& cell = cells_[batch.cells[i]];
    n_cells_ -= cell != SurfaceBatch::kRemoved ? 1 : 0;
    n_cells_ += batch.corners[i] != SurfaceBatch::kRemoved ? 1 : 0;
    cell = batch.corners[i];
  }
}

Surface SurfaceMirror::to_surface() const {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFU;
  Surface surface;
  surface.origin = origin_;
  std::vector<std::uint32_t> id(positions_.size(), kUnused);
  for (const SurfaceBatch::Cell& cell : cells_) {
    if (cell == SurfaceBatch::kRemoved) continue;
    for (const std::uint32_t slot : cell) id[slot] = 0;
  }
  for (std::size_t slot = 0; slot < id.size(); ++slot) {
    if (id[slot] == kUnused) continue;
    id[slot] = static_cast<std::uint32_t>(surface.positions.size());
    surface.positions.push_back(positions_[slot]);
    if (!normals_.empty()) surface.normals.push_back(normals_[slot]);
  }
  for (const SurfaceBatch::Cell& cell : cells_) {
    if (cell == SurfaceBatch::kRemoved) continue;
    if (cell[1] == cell[2])
      surface.lines.push_back({id[cell[0]], id[cell[1]]});
    else
      surface.triangles.push_back({id[cell[0]], id[cell[1]], id[cell[2]]});
  }
  return surface;
}

}  // namespace lode
