#pragma once

#include <string>

#include "input.h"
#include "query_options.h"

namespace lode::cli {

/// The arguments of `lode extract` for what is no isosurface: meshes and sections.
struct MeshJob {
  const std::string& input;
  const std::string& output;
  const std::string& memory_limit;
  const ExtractionArguments& extraction;
  const QueryArguments& query;
  const ReadingArguments& reading;
};

/// Looks at the arguments alone.
[[nodiscard]] Result<void> check_mesh_job(const MeshJob& job);
[[nodiscard]] Result<Outcome> run_mesh_job(const MeshJob& job, Session& session);

}  // namespace lode::cli
