#pragma once

#include <span>

#include "lode/core/progress.h"
#include "lode/models/diamond/attribute_check.h"
#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/coarse_field.h"
#include "lode/store/reader.h"

namespace lode::diamond {

/// What comparing blocks has found so far.
struct BlockFindings {
  AttributeFinding nodes;   ///< Errors and ranges are what they should be.
  AttributeFinding worlds;  ///< World errors are.
  std::uint64_t n_blocks = 0;

  void append(const BlockFindings& later);
};

/// A file whose blocks are compared.
template <int D>
struct ComparedFile {
  const store::Reader& reader;
  Shape<D> shape;            ///< Of its whole field.
  bool with_worlds = false;  ///< Whether it has world errors.
};

/// Compares the blocks of groups with what a field gives that was built of the file's samples, node
/// by node. `origin`: see visit_block_values(). Fails where a block is missing, of another size or
/// damaged, where samples beyond the data are not the nearest ones, and on cancel.
template <int D, typename Field>
[[nodiscard]] Result<void> compare_groups(const ComparedFile<D>& file, const Field& field,
                                          const WorldErrors& worlds, const Index<D>& origin,
                                          std::span<const BlockGroup<D>> groups, Threads threads,
                                          const Progress& progress, BlockFindings& findings);

}  // namespace lode::diamond
