#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/critical_nodes.h"

namespace lode {

/// What keep_topology cannot go with.
[[nodiscard]] Result<void> check_keep_topology(const ExtractOptions& options);

/// Whether pieces that do not persist are left out of a surface that is extracted: not where full
/// resolution is to be near.
[[nodiscard]] bool leaves_out_weak(const ExtractOptions& options);

/// Of a surface that is extracted within report.max_error: whether its topology is kept, and has to
/// be searched for that.
void begin_topology(const ExtractOptions& options, ExtractReport& report);

}  // namespace lode
