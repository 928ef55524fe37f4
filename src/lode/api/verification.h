#pragma once

#include <optional>

#include "lode/api/dataset.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/rebuild_check.h"
#include "lode/store/reader.h"

namespace lode {

/// Recomputes own errors and ranges of all stored nodes sample by sample, by a path of its own
/// (interpolants evaluated directly), and compares: own <= stored, stored nested.
template <int D>
[[nodiscard]] Result<VerifyReport> verify_model_against(const diamond::Model<D>& model,
                                                        VolumeSource& original, Threads threads,
                                                        Progress& progress);

/// The first part of that, of a file whose model is not in memory: grid and samples, box by box.
template <int D>
[[nodiscard]] Result<VerifyReport> verify_samples_against(const store::Reader& reader,
                                                          VolumeSource& original,
                                                          const diamond::RebuildSettings& settings,
                                                          Progress& progress);

/// Finds errors, ranges and, where it has them, world errors of a file anew from its samples, part
/// by part, and compares: a file must not claim smaller errors than it has. Says that this is left
/// out where it would take more memory than settings.memory_limit, > 0.
template <int D>
[[nodiscard]] Result<void> verify_attributes(const store::Reader& reader,
                                             const diamond::RebuildSettings& settings,
                                             Progress& progress, VerifyReport& report);

/// What a query makes.
struct ExpectedSurface {
  const Surface& surface;
  double tolerance = 0;
  double style_error = 0;  ///< By which the style may exceed it.
  /// Where what the query makes, or simplification, is held against it: the surface of full
  /// resolution.
  const Surface* full_resolution = nullptr;
  /// Of cubes at full resolution: the level set there, from which they keep no distance.
  const Surface* level_set = nullptr;
  /// How far it may be from full resolution, in place of the cut's own checks; or 0.
  double max_distance = 0;
  /// Its pieces are to be like those; or, with a persistence, some of these.
  std::optional<double> keep_topology{};
};

/// Checks a surface against the model's samples, and against what the query makes; see
/// Dataset::verify_surface.
template <int D>
[[nodiscard]] Result<VerifyReport> verify_model_surface(const diamond::Model<D>& model,
                                                        const Surface& surface,
                                                        const ExpectedSurface& expected,
                                                        const ExtractOptions& options,
                                                        Progress& progress);

/// Checks a surface against the model's samples alone; see Dataset::verify_bound.
template <int D>
[[nodiscard]] Result<VerifyReport> verify_surface_bound(const diamond::Model<D>& model,
                                                        const Surface& surface,
                                                        const BoundOptions& options,
                                                        Progress& progress);

}  // namespace lode
