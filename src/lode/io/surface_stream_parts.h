#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

#include "lode/core/expects.h"
#include "lode/io/patched_spool.h"
#include "lode/io/surface_layout.h"
#include "lode/io/surface_output.h"
#include "lode/io/surface_stream.h"

namespace lode::io {

/// Adds a piece to what the file's head will say.
inline void note(const SurfacePiece& piece, SurfaceLayout& layout) {
  const SurfaceLayout here = SurfaceLayout::of(piece.surface);
  LODE_EXPECTS(!here.has_values && !here.has_origins && !here.has_errors && !here.has_regions);
  layout.origin = here.origin;
  if (here.n_vertices > 0) {
    LODE_EXPECTS(layout.n_vertices == 0 || layout.has_normals == here.has_normals);
    LODE_EXPECTS(layout.n_vertices == 0 || layout.has_isovalues == here.has_isovalues);
    layout.has_normals = here.has_normals;
    layout.has_isovalues = here.has_isovalues;
  }
  layout.n_vertices += piece.n_new();
  layout.n_triangles += here.n_triangles;
  layout.n_lines += here.n_lines;
}

/// Where spools of an output go.
inline std::string directory_of(const std::string& path) {
  const std::string directory = std::filesystem::path(path).parent_path().string();
  return directory.empty() ? "." : directory;
}

/// Appends all of a spool to the output.
[[nodiscard]] inline Result<void> copy(const PatchedSpool& spool, SurfaceOutput& file) {
  return spool.read(1, [&](std::span<const std::byte> bytes) { return file.write(bytes); });
}

/// Triangles (lines) with their corners' numbers in the whole surface.
template <typename Cell>
Cell numbered(const SurfacePiece& piece, Cell cell) {
  for (std::uint32_t& vertex : cell) vertex = piece.number(vertex);
  return cell;
}

[[nodiscard]] Result<std::unique_ptr<SurfaceStream>> stream_ply(const std::string& path,
                                                                std::uint64_t memory_bytes,
                                                                Threads threads,
                                                                Progress& progress);
[[nodiscard]] Result<std::unique_ptr<SurfaceStream>> stream_stl(const std::string& path,
                                                                std::uint64_t memory_bytes,
                                                                Threads threads,
                                                                Progress& progress);
[[nodiscard]] Result<std::unique_ptr<SurfaceStream>> stream_vtp(const std::string& path,
                                                                std::uint64_t memory_bytes,
                                                                Threads threads,
                                                                Progress& progress);

}  // namespace lode::io
