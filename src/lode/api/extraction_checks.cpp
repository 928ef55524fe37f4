// What can be said of an extraction's options before anything is done.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/api/dataset_impl.h"
#include "lode/api/distance_extraction.h"
#include "lode/api/simplification.h"
#include "lode/api/topology_extraction.h"
#include "lode/mappers/lattice_frame.h"

namespace lode {
namespace {

Result<void> check_is_volume(const Dataset::Impl& impl, const ExtractOptions& options) {
  if (!impl.is_flat()) return {};
  const char* const asked = options.simplify != Simplify::off ? "simplifying"
                            : options.max_distance            ? "max_distance"
                            : options.keep_topology           ? "keep_topology"
                                                              : nullptr;
  if (asked == nullptr) return {};
  return fail("{}: expected a volume, got a flat image, whose contours are lines", asked);
}

Result<void> check_coordinates(const Dataset::Impl& impl) {
  const RegularGrid& grid = impl.info().grid;
  constexpr double kMost = std::numeric_limits<float>::max() / 16;
  const Vec3d origin = LatticeFrame::of(grid).surface_origin;
  const Box3d bounds = grid.world_bounds();
  for (std::size_t i = 0; i < 3; ++i)
    for (const double x : {bounds.lower[i] - origin[i], bounds.upper[i] - origin[i]})
      if (!(std::abs(x) <= kMost))
        return fail(
            "{}expected a volume no larger than {:.2g}, whose surfaces have coordinates in "
            "float32, got one up to {:.2g}",
            impl.path().empty() ? "" : impl.path() + ": ", kMost, std::abs(x));
  return {};
}

/// Two surfaces in one place are of no use.
Result<void> check_each_once(std::vector<double> isovalues) {
  std::sort(isovalues.begin(), isovalues.end());
  const auto twice = std::adjacent_find(isovalues.begin(), isovalues.end());
  if (twice == isovalues.end()) return {};
  return fail("isovalues: expected each once, got {} twice", *twice);
}

}  // namespace

double coordinate_step(const RegularGrid& grid) {
  const Box3d bounds = grid.world_bounds();
  Vec3d units;
  for (std::size_t i = 0; i < 3; ++i)
    units[i] = 0x1p-52 * std::max(std::abs(bounds.lower[i]), std::abs(bounds.upper[i]));
  return std::max(LatticeFrame::of(grid).rounding, in_steps(grid, units));
}

Result<void> check_extract_options(const ExtractOptions& options) {
  if (options.isovalues.empty()) return fail("expected at least one isovalue, got none");
  for (const double c : options.isovalues)
    if (!std::isfinite(c)) return fail("expected a finite isovalue, got {}", c);
  if (options.max_error && !(*options.max_error >= 0 && std::isfinite(*options.max_error)))
    return fail("expected a finite max_error >= 0, got {}", *options.max_error);
  if (options.style_distance && options.style != SurfaceStyle::cubes)
    return fail("style_distance: expected the style of cubes with it, got that of tetrahedra");
  if (options.style_distance && !(*options.style_distance > 0))
    return fail("expected a style_distance > 0, got {}", *options.style_distance);
  if (options.clip)
    for (std::size_t i = 0; i < 3; ++i)
      if (!(options.clip->lower[i] < options.clip->upper[i]))
        return fail("expected a clip box with lower < upper on each axis, got {} and {} on axis {}",
                    options.clip->lower[i], options.clip->upper[i], i);
  if (options.border == Border::closed && options.isovalues.size() > 1)
    return fail(
        "closing at the border: expected one isovalue, got {}: caps of several would lie "
        "in each other",
        options.isovalues.size());
  if (options.border == Border::closed && options.clip)
    return fail("closing at the border: expected no clip box, whose cut would stay open");
  LODE_CHECK(check_max_distance(options));
  LODE_CHECK(check_keep_topology(options));
  return {};
}

Result<void> check_extraction(const Dataset::Impl& impl, const ExtractOptions& options) {
  LODE_CHECK(check_extract_options(options));
  LODE_CHECK(check_simplify(options, tolerance_of(impl.summary().stats, options)));
  LODE_CHECK(check_each_once(options.isovalues));
  LODE_CHECK(check_coordinates(impl));
  return check_is_volume(impl, options);
}

}  // namespace lode
