#pragma once

#include <cstdint>
#include <optional>

#include "lode/models/diamond/cell_field.h"
#include "lode/models/diamond/cell_pieces.h"

namespace lode::diamond {

enum class CellState : std::uint8_t { present, removed };

/// Of `cell` and the cells round it, one in that state whose closed box, grown by `rounding` (index
/// units, per axis), holds the whole piece.
[[nodiscard]] std::optional<Index3> find_near_cell(const FieldSamples& samples, const Index3& cell,
                                                   const Piece& piece, const Vec3d& rounding,
                                                   CellState state);

}  // namespace lode::diamond
