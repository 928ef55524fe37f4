#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

struct BuildSettings {
  Threads threads;
  std::int32_t slices_per_read = 0;  ///< Most slices asked of the source at once; 0: chosen.
  bool with_worlds = false;          ///< World errors too.
};

/// Fails where an axis has no samples or too many.
[[nodiscard]] Result<void> check_axes(const VolumeInfo& info);

/// Builds the hierarchy of a volume: reads each sample once, then finds exact nested errors and
/// ranges of all nodes. Fails when the source does, when an axis is too long, or on cancel.
template <int D>
[[nodiscard]] Result<Model<D>> build(VolumeSource& source, const BuildSettings& settings,
                                     Progress& progress);

/// The second half of that: finds the attributes of all nodes of a model whose samples are complete
/// (see finish_samples()), and world errors where asked for. Fails on cancel.
template <int D>
[[nodiscard]] Result<void> build_attributes(Model<D>& model, bool with_worlds, Threads threads,
                                            Progress& progress);

/// Recomputes the attributes of level 0 (which are not stored) from the samples.
template <int D>
void compute_level_0(Model<D>& model, Threads threads);

}  // namespace lode::diamond
