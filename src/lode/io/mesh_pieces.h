#pragma once

#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"

namespace lode::io {

/// A piece's fields in the order of those of the pieces before it, whose types become float64 where
/// the piece has another. Fails when there are others or fewer.
[[nodiscard]] Result<std::vector<const MeshField*>> matching_fields(
    const std::string& path, std::vector<MeshField>& fields, const std::vector<MeshField>& piece);

/// Appends a piece's points, cells and values. Fails when the mesh grows too large or a piece lacks
/// a field of the others; pieces without points and cells may.
[[nodiscard]] Result<void> append_piece(CellMesh&& piece, CellMesh& mesh);

}  // namespace lode::io
