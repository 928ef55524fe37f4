#include "lode/io/waiting_stream.h"

#include <algorithm>

namespace lode::io {

Result<void> WaitingStream::add(SurfacePiece piece) {
  note(piece, layout_);
  if (piece.surface.positions.empty()) return {};
  if (!is_spooled_) {
    n_bytes_ += piece.surface.n_bytes() + piece.earlier.size() * sizeof(std::uint32_t);
    if (n_bytes_ <= memory_bytes_) {
      pieces_.push_back(std::move(piece));
      return {};
    }
    is_spooled_ = true;
    for (SurfacePiece& waiting : pieces_) {
      LODE_CHECK(spool(waiting));
      waiting = {};
    }
    pieces_ = {};
  }
  return spool(piece);
}

void WaitingStream::set_normals(std::span<const VertexNormal> normals) {
  for (const VertexNormal& normal : normals) {
    if (is_spooled_) {
      set_spooled_normal(normal);
      continue;
    }
    // The last piece that begins no later; those without new vertices begin where the next one
    // does.
    const auto next = std::upper_bound(
        pieces_.begin(), pieces_.end(), normal.vertex,
        [](std::uint32_t vertex, const SurfacePiece& piece) { return vertex < piece.first_new; });
    SurfacePiece& piece = *std::prev(next);
    piece.surface.normals[normal.vertex - piece.first_new] = normal.normal;
  }
}

}  // namespace lode::io
