#include "lode/api/simplification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "lode/core/stopwatch.h"
#include "lode/mappers/band_components.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/zero_normals.h"
#include "lode/models/diamond/cube_deviation.h"
#include "lode/models/diamond/field_band.h"

namespace lode {
namespace {

/// Of max_error what extraction takes. Simplification needs the rest, and nothing that is there
/// already has to be collapsed: on bonsai 0.25 leaves more triangles, after more time.
constexpr double kExtractionShare = 0.5;
/// Of a distance what cubes may take where simplification begins with them: with more there are
/// fewer triangles to begin with, but what is left of the distance takes longer to prove.
constexpr double kStartShare = 0.2;

/// From so many steps of the grid on cubes are begun with in any case. From one on, where a look at
/// some cells says that so many of them are near: of noise fewer are, and longer proofs and more
/// triangles that are left are not worth it.
constexpr double kSurelyWorth = 2;
constexpr double kLeastCubes = 0.7;

/// Of the distance that is asked for beside an error what extraction takes; 0 where there is none.
double extraction_distance(const ExtractOptions& options, double tolerance) {
  const bool is_both = has_band(options, tolerance) && options.simplify_distance &&
                       options.style == SurfaceStyle::tetra;
  return is_both ? kExtractionShare * *options.simplify_distance : 0;
}

/// Cubes of two isovalues may meet; boxes and the sizes of components are to be those of the
/// tetrahedra's surface.
bool may_begin_near(const ExtractOptions& options, double tolerance) {
  return options.simplify == Simplify::edges && options.simplify_distance &&
         options.style == SurfaceStyle::tetra && tolerance == 0 && options.isovalues.size() == 1 &&
         !options.max_distance && !options.clip && options.min_component <= 1;
}

double longest_step(const RegularGrid& grid) {
  double longest = 0;
  for (const double step : grid.spacing.v) longest = std::max(longest, std::abs(step));
  return longest;
}

/// How far a point of the grid is at most from where its coordinates are stored.
double coordinate_rounding(const RegularGrid& grid) {
  const Vec3d shift = LatticeFrame::of(grid).surface_origin;
  Vec3d last;
  for (std::size_t i = 0; i < 3; ++i) last[i] = static_cast<double>(grid.dims[i] - 1);
  double largest = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3d index;
    for (std::size_t i = 0; i < 3; ++i) index[i] = (corner >> i & 1) != 0 ? last[i] : 0;
    largest = std::max(largest, length(grid.to_world(index) - shift));
  }
  return largest * static_cast<double>(std::numeric_limits<float>::epsilon());
}

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
    return fail(
        "simplifying within a max_error: expected one isovalue, got {}: .stl and .obj, which get a "
        "file for each, may have several, each simplified by itself",
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
  if (has_band(options, tolerance)) {
    before.max_error = kExtractionShare * tolerance;
    // What is farther than the error keeps its side.
    if (options.keep_topology) before.keep_topology = std::min(*options.keep_topology, tolerance);
    // The distance is from all of full resolution.
    if (extraction_distance(options, tolerance) > 0) before.leaves_out_weak = false;
  }
  // Else it may have lost what the distance is to keep.
  if (const double distance = extraction_distance(options, tolerance); distance > 0)
    before.max_distance = std::min(distance, options.max_distance.value_or(distance));
  before.simplify = Simplify::off;
  before.simplify_distance.reset();
  return before;
}

Result<SimplifyStart> start_of_simplification(const ExtractOptions& options,
                                              const RegularGrid& grid, double tolerance,
                                              const diamond::Model<3>* model, Progress& progress) {
  SimplifyStart start{before_simplification(options, tolerance)};
  start.distance = extraction_distance(options, tolerance);
  if (!may_begin_near(options, tolerance)) return start;
  const double near = kStartShare * *options.simplify_distance;
  const double distance = near + 2 * coordinate_rounding(grid);
  if (!(distance < 2 * near)) return start;
  if (*options.simplify_distance < kSurelyWorth * longest_step(grid)) {
    if (*options.simplify_distance < longest_step(grid) || model == nullptr || model->has_holes())
      return start;
    LODE_TRY(const double share, diamond::share_of_cubes(*model,
                                                         {.isovalue = options.isovalues.front(),
                                                          .style = SurfaceStyle::cubes,
                                                          .style_distance = near,
                                                          .threads = options.threads},
                                                         progress));
    if (share < kLeastCubes) return start;
  }
  start.distance = distance;
  start.options.style = SurfaceStyle::cubes;
  start.options.style_distance = near;
  start.options.deviation = Deviation::unknown;
  return start;
}

SimplifyOptions simplify_options_of(const ExtractOptions& options, const SimplifyStart& start) {
  SimplifyOptions simplify{.threads = options.threads};
  simplify.max_distance =
      options.simplify_distance.value_or(std::numeric_limits<double>::infinity()) - start.distance;
  if (options.simplify == Simplify::slivers) simplify.longest_edge = *options.simplify_distance;
  return simplify;
}

/// Where the field has values, but for holes, and what was not clipped, of positions counted from
/// `origin`.
ConvexDomain domain_of(const RegularGrid& grid, const ExtractOptions& options,
                       const Vec3d& origin) {
  const Mat3 m = grid.index_to_world_matrix();
  const Mat3 c = cofactors(m);
  const bool is_clipped = options.clip && grid.has_world_axes();
  ConvexDomain domain;
  for (std::size_t i = 0; i < 3; ++i) {
    domain.along[i] = c.column(i) * (1 / determinant(m));
    double low = 0;
    double high = grid.dims[i] - 1;
    if (is_clipped) {
      const double a = grid.to_index(options.clip->lower)[i];
      const double b = grid.to_index(options.clip->upper)[i];
      low = std::max(low, std::min(a, b));
      high = std::min(high, std::max(a, b));
    }
    domain.at[i] = dot(domain.along[i], origin - grid.origin) - low;
    domain.most[i] = high - low;
  }
  return domain;
}

void add_start(const SimplifyStart& start, const ExtractOptions& options, SimplifyReport& report) {
  if (start.distance == 0) return;
  report.max_distance = *options.simplify_distance;
  report.start_distance = start.distance;
  report.proven_distance += start.distance;
}

Result<void> simplify(const Dataset::Impl& impl, const ExtractOptions& options,
                      const SimplifyStart& start, Surface& surface, ExtractReport& report,
                      Progress& progress) {
  const Stopwatch watch;
  LODE_TRY(const auto band, band_of(impl, options, report.max_error, progress));
  Dropped dropped;
  if (band && drops_components(options)) {
    LODE_TRY(dropped, drop_components_in_band(surface, *band, options.threads, progress));
  }
  SimplifyOptions simplify = simplify_options_of(options, start);
  simplify.band = band.get();
  const ConvexDomain domain = domain_of(impl.info().grid, options, surface.origin);
  simplify.domain = &domain;
  LODE_TRY(report.simplified, simplify_surface(surface, simplify, progress));
  fill_zero_normals(surface, options.threads);  // of those whose mean is none
  report.simplified->components_dropped = dropped.components;
  report.simplified->triangles_dropped = dropped.cells;
  add_start(start, options, *report.simplified);
  report.seconds.simplify = watch.seconds();
  return {};
}

}  // namespace lode
