#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "lode/api/tetra_dataset.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode {

/// The mesh that a model was built from, with other fields, or the same at another time.
struct TetraStep {
  TetraMesh mesh;
  std::optional<double> time{};
  std::string source;  ///< For messages.
  /// What is said of how its fields were read: kept with what the file says of the mesh.
  std::vector<TetraBuildRecord::Note> notes{};
};

struct TetraAttachReport {
  TetraInfo info;                ///< Of the file that was made.
  std::uint64_t n_attached = 0;  ///< Of its fields, the last.
  std::uint64_t file_bytes = 0;
  double seconds = 0;
};

/// The next step, or none after the last.
using NextTetraStep = std::function<Result<std::optional<TetraStep>>()>;

/// Makes a .lode file of all that a model of tetrahedra has and of further fields, each with errors
/// at samples, measured in one pass over the nodes; no collapse is chosen anew. One step is in
/// memory at a time. Fails where a step's mesh is another, or a field of that name and time is
/// there. The output, which may be the model itself, appears whole or not at all.
[[nodiscard]] Result<TetraAttachReport> attach_fields(const std::string& model,
                                                      const std::string& output,
                                                      const NextTetraStep& next, Threads threads,
                                                      Progress& progress);

}  // namespace lode
