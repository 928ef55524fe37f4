#pragma once

#include "extract_mesh.h"

namespace lode::cli {

/// `lode extract` for one surface with foci, a view, a budget or a deadline. Looks at the arguments
/// alone.
[[nodiscard]] Result<void> check_focused_job(const MeshJob& job);
[[nodiscard]] Result<Outcome> run_focused_job(const MeshJob& job, Session& session);

}  // namespace lode::cli
