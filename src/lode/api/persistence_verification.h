#pragma once

#include "lode/api/dataset.h"
#include "lode/api/verify_report.h"
#include "lode/models/diamond/cell_field.h"

namespace lode {

/// Whether a surface with its topology kept parts as many regions as persist, at least: in a volume
/// without holes each of its pieces parts one region in two. Which ones they are is not looked at.
[[nodiscard]] Result<void> add_persistent(const diamond::FieldSamples& samples, bool has_holes,
                                          const Surface& surface, const ExtractOptions& options,
                                          Progress& progress, VerifyReport& report);

}  // namespace lode
