#include "lode/api/terrain_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "lode/api/terrain_tin_impl.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/core/vertical_unit.h"

namespace lode {
namespace {

/// Where coordinates are angles pieces are cut until height is linear in distance, too: in 0.001
/// degrees the two differ by less than 0.3 mm of the way below latitudes of 45 degrees.
constexpr double kLongestAngle = 0.001 * std::numbers::pi / 180;
/// The same where distances are measured in another CRS, in metres.
constexpr double kLongestWay = 100;

/// The way from the observer to the target, in metres, and the places of its points.
class SightWay {
 public:
  SightWay(const TerrainTin::Impl& tin, const TerrainSightOptions& options, double vertical)
      : tin_(tin), options_(options), vertical_(vertical), last_(options.from) {}

  Result<void> follow(Progress& progress) {
    const Place a = tin_.to_lattice(options_.from);
    const Place b = tin_.to_lattice(options_.to);
    if (a == b) return fail("expected two places that differ by more than rounding, got one");
    LODE_TRY(const std::vector<ProfilePoint> profile, tin_.profile(a, b, progress));
    if (profile.empty() || profile.front().t > 0) return off_terrain("observer", options_.from);
    if (profile.back().t < 1) return off_terrain("target", options_.to);
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const ProfilePoint& here = profile[i];
      const bool is_gap = i + 1 < profile.size() && profile[i + 1].starts_part;
      add(here.t, here.height, here.error, here.rounding, is_gap);
      points_.back().is_step = here.is_step;
      if (i + 1 < profile.size() && !is_gap && !here.is_step) cut(here, profile[i + 1]);
      if (!std::isfinite(distance_)) return TerrainTin::Impl::not_measured(last_);
    }
    return {};
  }
  [[nodiscard]] const std::vector<SightPoint>& points() const { return points_; }
  /// Between two points.
  [[nodiscard]] Place place_at(std::size_t piece, double share) const {
    return places_[piece] * (1 - share) + places_[piece + 1] * share;
  }

 private:
  static Error off_terrain(const char* who, const Place& at) {
    return fail("expected the {} on the terrain, got {}, {}, which is outside of it or in a gap",
                who, at[0], at[1]);
  }
  void add(double t, double height, double error, double rounding, bool is_gap) {
    const Place at = t == 1 ? options_.to : options_.from * (1 - t) + options_.to * t;
    distance_ += tin_.metric.distance(std::exchange(last_, at), at) * tin_.metric.metres();
    points_.push_back({distance_, height * vertical_, tin_.error_bound(error) * vertical_,
                       rounding * vertical_, is_gap});
    places_.push_back(at);
  }
  /// In how many pieces distances are as good as linear.
  [[nodiscard]] double n_pieces(const Place& way) const {
    const HorizontalMetric& metric = tin_.metric;
    if (!metric.ellipsoid && !metric.map) return 1;
    const double longer = std::max(std::abs(way[0]), std::abs(way[1]));
    constexpr double kMost = 0x1p18;  // round the earth
    return std::min(kMost, std::ceil(metric.ellipsoid ? longer * metric.angle_unit / kLongestAngle
                                                      : longer * metric.length_unit / kLongestWay));
  }
  void cut(const ProfilePoint& from, const ProfilePoint& to) {
    const double n = n_pieces((options_.to - options_.from) * (to.t - from.t));
    const double rounding = std::max(from.rounding, to.rounding) +
                            0x1p-50 * std::max(std::abs(from.height), std::abs(to.height));
    for (double k = 1; k < n && std::isfinite(distance_); ++k)
      add(from.t + (to.t - from.t) * k / n, from.height + (to.height - from.height) * k / n,
          from.error, rounding, false);
  }

  const TerrainTin::Impl& tin_;
  const TerrainSightOptions& options_;
  double vertical_;
  Place last_;
  double distance_ = 0;
  std::vector<SightPoint> points_;
  std::vector<Place> places_;
};

}  // namespace

Result<TerrainSight> TerrainTin::sight(const TerrainSightOptions& options, Progress& progress) const
    try {
  TerrainSight sight;
  const Place& from = options.from;
  const Place& to = options.to;
  LODE_CHECK(check_angles(impl_->metric, {{std::min(from[0], to[0]), std::min(from[1], to[1])}},
                          {{std::max(from[0], to[0]), std::max(from[1], to[1])}}));
  const std::optional<double> vertical = options.vertical_metres
                                             ? options.vertical_metres
                                             : metres_of_unit(impl_->frame.vertical_unit);
  sight.is_vertical_unit_known = vertical.has_value();
  sight.vertical_metres = vertical.value_or(impl_->metric.assumed_height_unit());
  const std::optional<Ellipsoid>& measured = impl_->metric.measured().ellipsoid;
  const Ellipsoid earth = measured ? *measured : impl_->metric.ellipsoid.value_or(kWgs84Ellipsoid);
  sight.radius = earth.mean_radius();
  SightWay way(*impl_, options, sight.vertical_metres);
  LODE_CHECK(way.follow(progress));
  const SightAnswer answer =
      find_sight(way.points(), {.observer_height = options.observer_height * sight.vertical_metres,
                                .target_height = options.target_height * sight.vertical_metres,
                                .curvature = (1 - options.refraction) / sight.radius});
  const SightPoint& begin = way.points()[answer.worst.piece];
  const SightPoint& end = way.points()[answer.worst.piece + 1];
  const double run = end.distance - begin.distance;
  const double share = run > 0 ? (answer.worst.distance - begin.distance) / run : 0;
  sight.verdict = answer.verdict;
  sight.has_gap = answer.has_gap;
  sight.distance = way.points().back().distance / impl_->metric.metres();
  sight.at = way.place_at(answer.worst.piece, share);
  sight.at_distance = answer.worst.distance / impl_->metric.metres();
  sight.terrain_height =
      (begin.height + share * (end.height - begin.height)) / sight.vertical_metres;
  sight.above_low = answer.worst.low / sight.vertical_metres;
  sight.above_high = answer.worst.high / sight.vertical_metres;
  return sight;
} catch (const std::bad_alloc&) {
  return out_of_memory("find the line of sight");
}

Result<TerrainSight> find_terrain_sight(const Terrain& terrain, const TerrainOptions& tin_options,
                                        const HorizontalMetric& metric,
                                        const TerrainSightOptions& options,
                                        Progress& progress) try {
  const Stopwatch watch;
  TerrainOptions wanted = tin_options;
  Terrain asked = terrain;
  for (std::uint32_t round = 1;; ++round) {
    LODE_TRY(const TerrainTin tin,
             TerrainTin::select(asked, wanted, metric, progress, TinUse::places));
    LODE_TRY(TerrainSight sight, tin.sight(options, progress));
    sight.n_rounds = round;
    sight.terrain = tin.report();
    sight.seconds = watch.seconds();
    sight.finest_error = asked.origin().finest_error();
    if (options.effort == SightEffort::once || sight.verdict != SightVerdict::undecided)
      return sight;
    if (sight.is_finest()) {
      // A model was built of a part of all heights, or with rounding of its own: where these are at
      // hand, they have the last word.
      if (asked.origin().is_raster() || !wanted.samples) return sight;
      asked = Terrain(wanted.samples);
      sight.finest_error = 0;
    }
    // All samples are had sooner than those that greed finds at any tolerance between.
    wanted.max_error = sight.finest_error;
  }
} catch (const std::bad_alloc&) {
  return out_of_memory("find the line of sight");
}

}  // namespace lode
