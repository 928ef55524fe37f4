#pragma once

#include "lode/models/diamond/coarse_field.h"
#include "lode/models/diamond/part_builder.h"
#include "lode/models/diamond/summary.h"

namespace lode::diamond {

/// After all parts have given their shares: nests errors, ranges and world errors of the nodes that
/// the field has kept, and rounds their ranges as they are stored.
template <int D>
void nest_coarse(CoarseField<D>& field, Threads threads);

/// Of a field that was built so, part by part.
template <int D>
[[nodiscard]] Summary summarize(const CoarseField<D>& field, const PartBuilder<D>& builder);

}  // namespace lode::diamond
