#pragma once

#include <optional>

#include "lode/api/dataset_impl.h"
#include "lode/api/isovalue_passes.h"
#include "lode/models/diamond/node_set.h"

namespace lode {

/// The nodes of a file that keep_topology and max_distance want refined, found chunk by chunk: of
/// all isovalues together.
class ChunkNodes {
 public:
  /// Beside what extraction takes, a quarter of the limit is for the nodes, half of it for the
  /// triangles that finding them takes.
  ChunkNodes(Dataset::Impl::Chunks& chunks, const ExtractOptions& options,
             std::uint64_t memory_limit)
      : chunks_(chunks), options_(options), memory_limit_(memory_limit) {}

  /// Begins what the report says of surfaces within its max_error, and says where their nodes come
  /// from; nowhere if none are wanted.
  [[nodiscard]] WantedNodes begin(ExtractReport& report, Progress& progress);

 private:
  [[nodiscard]] Result<void> find(ExtractReport& report, Progress& progress);

  Dataset::Impl::Chunks& chunks_;
  const ExtractOptions& options_;
  std::uint64_t memory_limit_;
  std::optional<diamond::NodeSet<3>> nodes_;
};

}  // namespace lode
