#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/api/isovalue_parts.h"

namespace lode {

/// The isosurfaces of a model in memory, before any edit: into `surface` and `report`.
[[nodiscard]] Result<FieldFacts> extract_in_memory(const Dataset::Impl& impl,
                                                   const ExtractOptions& options, Surface& surface,
                                                   ExtractReport& report, Progress& progress);

}  // namespace lode
