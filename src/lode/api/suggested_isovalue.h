#pragma once

#include "lode/api/dataset.h"

namespace lode {

/// A value that parts a field in two as well as one can: where the variance between what is below
/// and what is above, by volume, is the largest (Otsu 1979), found on a coarse mesh of the field;
/// of whole numbers half way between two. Of a field of one value that one.
[[nodiscard]] Result<double> suggest_isovalue(const Dataset& dataset, Progress& progress);

}  // namespace lode
