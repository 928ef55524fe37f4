#pragma once

#include <optional>

#include "lode/api/common_nodes.h"
#include "lode/api/dataset_impl.h"
#include "lode/api/isovalue_passes.h"

namespace lode {

/// The nodes of a file that keep_topology and max_distance want refined, and what the surfaces
/// leave out, found chunk by chunk: of all isovalues together.
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
  /// Of the first isovalue; as far as they have been found.
  [[nodiscard]] bool is_first_weak() const {
    return nodes_ && nodes_->is_first_weak(options_.isovalues.front());
  }

 private:
  [[nodiscard]] Result<void> find(ExtractReport& report, Progress& progress);

  Dataset::Impl::Chunks& chunks_;
  const ExtractOptions& options_;
  std::uint64_t memory_limit_;
  std::optional<CommonNodes> nodes_;
};

}  // namespace lode
