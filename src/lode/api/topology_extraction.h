#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/critical_nodes.h"

namespace lode {

/// What keep_topology cannot go with.
[[nodiscard]] Result<void> check_keep_topology(const ExtractOptions& options);

/// Whether pieces that do not persist are left out: not where a distance is to be kept, nor where
/// samples beyond an error keep their sides.
[[nodiscard]] bool leaves_out_weak(const ExtractOptions& options);

/// Of a surface that is extracted within report.max_error: whether its topology is kept, and has to
/// be searched for that.
void begin_topology(const ExtractOptions& options, ExtractReport& report);

}  // namespace lode
