#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/critical_nodes.h"

namespace lode {

/// What keep_topology cannot go with.
[[nodiscard]] Result<void> check_keep_topology(const ExtractOptions& options);

/// The nodes that keep the topology of one isosurface, and their ancestors; adds to the report.
[[nodiscard]] Result<diamond::CriticalNodes> critical_nodes(const diamond::Model<3>& model,
                                                            double isovalue,
                                                            const ExtractOptions& options,
                                                            ExtractReport& report,
                                                            Progress& progress);

}  // namespace lode
