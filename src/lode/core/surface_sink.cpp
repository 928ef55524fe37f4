#include "lode/core/surface_sink.h"

#include <algorithm>

namespace lode {
namespace {

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& from, std::size_t n) {
  to.insert(to.end(), from.begin(),
            from.begin() + static_cast<std::ptrdiff_t>(std::min(n, from.size())));
}

template <typename Cell>
void append_cells(std::vector<Cell>& to, const std::vector<Cell>& from, const SurfacePiece& piece) {
  to.reserve(to.size() + from.size());
  for (Cell cell : from) {
    for (std::uint32_t& vertex : cell) vertex = piece.number(vertex);
    to.push_back(cell);
  }
}

}  // namespace

Result<void> SurfaceCollector::add(SurfacePiece piece) {
  surface_.origin = piece.surface.origin;
  append(surface_.positions, piece.surface.positions, piece.n_new());
  append(surface_.normals, piece.surface.normals, piece.n_new());
  append(surface_.isovalues, piece.surface.isovalues, piece.n_new());
  append_cells(surface_.triangles, piece.surface.triangles, piece);
  append_cells(surface_.lines, piece.surface.lines, piece);
  return {};
}

void SurfaceCollector::set_normals(std::span<const VertexNormal> normals) {
  for (const VertexNormal& n : normals) surface_.normals[n.vertex] = n.normal;
}

}  // namespace lode
