#include "lode/api/simplification.h"

#include <cmath>
#include <limits>
#include <memory>

#include "lode/core/stopwatch.h"
#include "lode/mappers/band_components.h"
#include "lode/models/diamond/field_band.h"

namespace lode {
namespace {

/// Of max_error what extraction takes. Simplification needs the rest, and nothing that is there
/// already has to be collapsed: on bonsai 0.25 leaves more triangles, after more time.
constexpr double kExtractionShare = 0.5;

Result<std::unique_ptr<SurfaceBand>> band_of(const Dataset::Impl& impl,
                                             const ExtractOptions& options, double tolerance,
                                             Progress& progress) {
  if (!has_band(options, tolerance)) return std::unique_ptr<SurfaceBand>();
  LODE_TRY(const auto* const held, impl.model(progress));
  return diamond::make_field_band(std::get<diamond::Model<3>>(*held), options.isovalues.front(),
                                  tolerance, options.threads);
}

}  // namespace

Result<void> check_simplify(const ExtractOptions& options, double tolerance) {
  if (options.simplify == Simplify::off) {
    if (!options.simplify_distance) return {};
    return fail("simplify_distance: expected simplify with it, which is off");
  }
  if (options.simplify_distance &&
      !(*options.simplify_distance > 0 && std::isfinite(*options.simplify_distance)))
    return fail("expected a finite distance > 0 to simplify within, got {}",
                *options.simplify_distance);
  if (options.simplify == Simplify::slivers && !options.simplify_distance)
    return fail("removing slivers: expected a simplify_distance, got none");
  if (options.border == Border::closed)
    return fail("simplifying: expected an open border, whose planes caps would leave");
  if (!has_band(options, tolerance)) {
    if (options.simplify_distance) return {};
    return fail("simplifying: expected a finite max_error > 0 or a simplify_distance, got {}",
                tolerance);
  }
  if (options.isovalues.size() > 1)
    return fail("simplifying within a max_error: expected one isovalue, got {}",
                options.isovalues.size());
  if (options.min_component > 1)
    return fail(
        "simplifying within a max_error: expected all pieces kept, got min_component {}, which "
        "drops what lies beyond the error, too",
        options.min_component);
  if (options.clip)
    return fail(
        "simplifying within a max_error: expected no clip box, which may cut off all samples that "
        "tell the sides of the surface");
  return {};
}

bool has_band(const ExtractOptions& options, double tolerance) {
  return options.simplify != Simplify::off && kExtractionShare * tolerance > 0 &&
         std::isfinite(tolerance);
}

bool drops_components(const ExtractOptions& options) {
  return !options.simplify_distance && !options.keep_topology;
}

ExtractOptions before_simplification(const ExtractOptions& options, double tolerance) {
  ExtractOptions before = options;
  if (has_band(options, tolerance)) before.max_error = kExtractionShare * tolerance;
  before.simplify = Simplify::off;
  before.simplify_distance.reset();
  return before;
}

SimplifyOptions simplify_options_of(const ExtractOptions& options) {
  SimplifyOptions simplify{.threads = options.threads};
  simplify.max_distance =
      options.simplify_distance.value_or(std::numeric_limits<double>::infinity());
  if (options.simplify == Simplify::slivers) simplify.longest_edge = simplify.max_distance;
  return simplify;
}

Result<void> simplify(const Dataset::Impl& impl, const ExtractOptions& options, Surface& surface,
                      ExtractReport& report, Progress& progress) {
  const Stopwatch watch;
  LODE_TRY(const auto band, band_of(impl, options, report.max_error, progress));
  Dropped dropped;
  if (band && drops_components(options)) {
    LODE_TRY(dropped, drop_components_in_band(surface, *band, options.threads, progress));
  }
  SimplifyOptions simplify = simplify_options_of(options);
  simplify.band = band.get();
  LODE_TRY(report.simplified, simplify_surface(surface, simplify, progress));
  report.simplified->components_dropped = dropped.components;
  report.simplified->triangles_dropped = dropped.cells;
  report.seconds.simplify = watch.seconds();
  return {};
}

}  // namespace lode
