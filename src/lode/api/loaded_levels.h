#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"

namespace lode {

/// The levels of a hierarchy of triangles, read from its file as far as they are wanted.
class LoadedLevels {
 public:
  using Shared = std::shared_ptr<const triangle_hierarchy::Hierarchy>;

  /// All are there.
  explicit LoadedLevels(triangle_hierarchy::Hierarchy all);
  /// None is.
  explicit LoadedLevels(hierarchy_file::HierarchyFile file);

  /// At least the first levels. From several threads at once; while one reads others wait.
  [[nodiscard]] Result<Shared> first(int n_levels, Progress& progress);

 private:
  std::mutex mutex_;
  std::optional<hierarchy_file::HierarchyFile> file_;
  Shared loaded_;
};

}  // namespace lode
