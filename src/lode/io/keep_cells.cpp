#include "lode/io/keep_cells.h"

#include <cstddef>

namespace lode::io {
namespace {

void keep_values(const std::vector<std::uint8_t>& is_kept, MeshField& field) {
  const auto n = static_cast<std::size_t>(field.n_components);
  std::size_t to = 0;
  for (std::size_t cell = 0; cell < is_kept.size(); ++cell) {
    if (is_kept[cell] == 0) continue;
    for (std::size_t k = 0; k < n; ++k) field.values[to++] = field.values[cell * n + k];
  }
  field.values.resize(to);
}

/// Moves what stays of one list of lists to its front.
template <typename T>
void keep_lists(const std::vector<std::uint8_t>& is_kept, std::vector<std::uint64_t>& begins,
                std::vector<T>& items) {
  std::size_t to = 0;
  std::size_t n_items = 0;
  for (std::size_t cell = 0; cell < is_kept.size(); ++cell) {
    if (is_kept[cell] == 0) continue;
    const auto begin = static_cast<std::size_t>(begins[cell]);
    const auto end = static_cast<std::size_t>(begins[cell + 1]);
    begins[to++] = n_items;
    for (std::size_t i = begin; i < end; ++i) items[n_items++] = items[i];
  }
  begins[to] = n_items;
  begins.resize(to + 1);
  items.resize(n_items);
}

}  // namespace

void keep_cells(const std::vector<std::uint8_t>& is_kept, CellMesh& mesh) {
  keep_lists(is_kept, mesh.begins, mesh.corners);
  if (!mesh.face_begins.empty()) keep_lists(is_kept, mesh.face_begins, mesh.faces);
  for (MeshField& field : mesh.cell_fields) keep_values(is_kept, field);
  std::size_t to = 0;
  for (std::size_t cell = 0; cell < is_kept.size(); ++cell)
    if (is_kept[cell] != 0) mesh.types[to++] = mesh.types[cell];
  mesh.types.resize(to);
}

}  // namespace lode::io
