#pragma once

#include <optional>

#include "lode/api/dataset.h"

namespace lode {

/// A value that parts a field in two as well as one can: where the variance between what is below
/// and what is above, by volume, is the largest (Otsu 1979), found on a coarse mesh of the field;
/// of types that hold whole numbers half way between two. None where there are no two parts: of one
/// value, or without cells.
[[nodiscard]] Result<std::optional<double>> suggest_isovalue(const Dataset& dataset,
                                                             Progress& progress);

}  // namespace lode
