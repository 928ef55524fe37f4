#include "lode/api/loaded_levels.h"

#include <utility>

namespace lode {

using triangle_hierarchy::Hierarchy;

LoadedLevels::LoadedLevels(Hierarchy all)
    : loaded_(std::make_shared<const Hierarchy>(std::move(all))) {}

LoadedLevels::LoadedLevels(hierarchy_file::HierarchyFile file) : file_(std::move(file)) {}

Result<LoadedLevels::Shared> LoadedLevels::first(int n_levels, Progress& progress) {
  const std::scoped_lock lock(mutex_);
  if (loaded_ && loaded_->n_levels() >= n_levels) return loaded_;
  LODE_TRY(auto model, file_->read(n_levels, progress));
  loaded_ = std::make_shared<const Hierarchy>(std::move(model.hierarchy));
  return loaded_;
}

}  // namespace lode
