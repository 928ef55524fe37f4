#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/mappers/simplify_surface.h"

namespace lode {

/// Refuses options that simplification does not go with. `tolerance`: the query's.
[[nodiscard]] Result<void> check_simplify(const ExtractOptions& options, double tolerance);

/// Whether triangles are to stay in the band of `tolerance` round the isovalue.
[[nodiscard]] bool has_band(const ExtractOptions& options, double tolerance);

/// Whether components may go that the band holds with all that they enclose.
[[nodiscard]] bool drops_components(const ExtractOptions& options);

/// The same query without simplification: what that starts from. Of an error and a distance half of
/// both.
[[nodiscard]] ExtractOptions before_simplification(const ExtractOptions& options, double tolerance);

/// What simplification begins with, and what of its distance is left.
struct SimplifyStart {
  ExtractOptions options;  ///< As before_simplification(), but maybe with cubes among tetrahedra.
  double distance = 0;     ///< Of that from full resolution, at most, both ways; world units.
};
/// Within a distance of full resolution cubes stand for tetrahedra where they are near: a third of
/// the triangles, and the same topology. `model`: what is extracted from; null of a file's parts.
[[nodiscard]] Result<SimplifyStart> start_of_simplification(const ExtractOptions& options,
                                                            const RegularGrid& grid,
                                                            double tolerance,
                                                            const diamond::Model<3>* model,
                                                            Progress& progress);

/// Without a band.
[[nodiscard]] SimplifyOptions simplify_options_of(const ExtractOptions& options,
                                                  const SimplifyStart& start);
/// Adds the start's distance to what was found from there on.
void add_start(const SimplifyStart& start, const ExtractOptions& options, SimplifyReport& report);

/// Simplifies an extracted surface as the options say, within report.max_error.
[[nodiscard]] Result<void> simplify(const Dataset::Impl& impl, const ExtractOptions& options,
                                    const SimplifyStart& start, Surface& surface,
                                    ExtractReport& report, Progress& progress);

}  // namespace lode
