#pragma once

#include <optional>

#include "lode/api/dataset_impl.h"
#include "lode/api/isovalue_passes.h"
#include "lode/models/diamond/critical_nodes.h"

namespace lode {

/// What keep_topology cannot go with.
[[nodiscard]] Result<void> check_keep_topology(const ExtractOptions& options);

/// Of a surface that is extracted within report.max_error: whether its topology is kept, and has to
/// be searched for that.
void begin_topology(const ExtractOptions& options, ExtractReport& report);

/// The nodes that keep the topology of one isosurface, and their ancestors; adds to the report.
[[nodiscard]] Result<diamond::CriticalNodes> critical_nodes(const diamond::Model<3>& model,
                                                            double isovalue,
                                                            const ExtractOptions& options,
                                                            ExtractReport& report,
                                                            Progress& progress);

/// The same of a file, chunk by chunk: those of one isovalue at a time.
class CriticalOfChunks {
 public:
  /// They may take max_bytes.
  CriticalOfChunks(Dataset::Impl::Chunks& chunks, const ExtractOptions& options,
                   std::uint64_t max_bytes)
      : chunks_(chunks), options_(options), max_bytes_(max_bytes) {}

  /// Empty where the topology is not searched; else adds to the report.
  [[nodiscard]] NodesOfIsovalue nodes_of(ExtractReport& report, Progress& progress);

 private:
  Dataset::Impl::Chunks& chunks_;
  const ExtractOptions& options_;
  std::uint64_t max_bytes_;
  std::optional<diamond::CriticalNodes> found_;
};

}  // namespace lode
