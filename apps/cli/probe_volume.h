#pragma once

#include "command.h"
#include "probe_options.h"
#include "probe_output.h"

namespace lode::cli {

/// Refuses, before the work starts, what no volume is probed with.
[[nodiscard]] Result<void> check_volume_probe(const ProbeArguments& arguments);

/// Probes a volume: its .lode file, or one that is built in memory.
[[nodiscard]] Result<Outcome> run_volume_probe(const ProbeArguments& arguments, const ProbeJob& job,
                                               Session& session);

}  // namespace lode::cli
