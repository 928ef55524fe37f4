#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "lode/api/dataset.h"
#include "lode/api/query.h"
#include "lode/refine/standing.h"

namespace lode {

struct FocusedOptions {
  /// One isovalue. Without a tolerance it is 0.5 % of the value range, or with a budget or a
  /// deadline 0: as good as they allow.
  Query query;
  /// Seconds from when refinement begins: not counted is what must be there before, a file's coarse
  /// levels, or for a view of a model in memory its world errors. The best surface that is complete
  /// by then is the answer.
  std::optional<double> deadline_s{};
  std::optional<Box3d> clip{};      ///< As in ExtractOptions; the deadline knows nothing of it.
  std::uint64_t min_component = 0;  ///< Likewise.
  Orientation orientation = Orientation::from_lower_values;
  Normals normals = Normals::on;
  Threads threads{};
  /// Bytes for the hierarchy; 0: as in LiveQueryOptions. Of a file that is read as the query goes
  /// half of them are for its pages, half for the cut and the surface (Standing::memory_met).
  std::uint64_t memory_limit = 0;
  /// Seconds since some moment; a steady clock, unless a test brings its own.
  std::function<double()> clock{};
};

struct FocusedReport {
  std::optional<double> max_error;     ///< Field units: asked for, or chosen.
  std::optional<double> max_error_px;  ///< As asked for.
  /// How much more |F - isovalue| may be than the error, for positions are float32: field units.
  double coordinate_slack = 0;
  Standing standing;  ///< n_steps repeats an answer of a model in memory that a deadline cut short.
  double achieved_px = 0;   ///< With a view: of what is left unrefined in sight, an estimate.
  double seconds = 0;       ///< Without the next two,
  double open_seconds = 0;  ///< for what is read before refinement begins, and
  double world_error_seconds = 0;  ///< what is found once for a model in memory.
  std::uint64_t components_dropped = 0;
  std::uint64_t triangles_dropped = 0;
  bool was_clipped = false;  ///< Nodes at the border were left unrefined, so the surface was cut.
};

/// An isosurface as good as its query wants it at each place: in regions, in a view, in a budget,
/// by a deadline. It is refined from the base, best first, on one thread; consistent whenever it
/// ends. Without view, regions, budget and deadline it is Dataset::extract()'s.
[[nodiscard]] Result<FocusedReport> extract_focused(const Dataset& dataset,
                                                    const FocusedOptions& options, Surface& surface,
                                                    Progress& progress);

}  // namespace lode
