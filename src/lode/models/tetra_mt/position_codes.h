#pragma once

#include <array>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/models/tetra_mt/number_models.h"

namespace lode::tetra_mt {

struct PositionModels {
  WideModel firsts;
  std::array<WideModel, 3> gaps;
  std::array<WideModel, 3> differences;
  /// By axis, parities of all places before, and steps of the axes before.
  std::array<std::array<std::array<std::array<BitModel, 3>, 16>, 8>, 3> steps;
  std::array<BitModel, 3> is_back;
  std::array<NumberModel, 3> far;
};

/// Codes the positions of a page (docs/format.md, section 7): where an axis has few coordinates,
/// these and their places, which go by single steps along a curve through a grid; else differences.
/// `Coder` is RangeWriter or RangeReader; a reader fills `positions`, which has as many as there
/// are, at most 512. Fails on what is no finite number.
template <typename Coder>
[[nodiscard]] Result<void> code_positions(Coder& coder, PositionModels& models, bool is_narrow,
                                          const std::string& what, std::vector<Vec3d>& positions);

}  // namespace lode::tetra_mt
