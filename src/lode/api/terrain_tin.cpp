#include "lode/api/terrain_tin.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "lode/api/terrain_tin_impl.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/tin_everywhere.h"

namespace lode {
namespace {

/// Bounds that hold between samples, too.
Result<void> hold_everywhere(const Terrain& terrain, const TerrainOptions& options,
                             SelectedTerrain& selected, Progress& progress) {
  const HeightGrid& grid = *options.samples;
  const std::int32_t scale = (terrain.frame().n_columns - 1) / (grid.n_columns - 1);
  LODE_CHECK(raise_errors_everywhere(grid, scale, options.threads, progress, selected.tin));
  TerrainReport& report = selected.report;
  report.is_everywhere = true;
  if (!selected.tin.errors.empty())
    report.achieved_error =
        std::max(report.achieved_error, static_cast<double>(std::ranges::max(selected.tin.errors)));
  return {};
}

Place first_unmeasured(const TerrainProfile& profile, const Place& to) {
  const auto at = std::ranges::find_if(
      profile.points, [](const auto& point) { return !std::isfinite(point.distance); });
  return at == profile.points.end() ? to : at->at;
}

}  // namespace

Error TerrainTin::Impl::not_measured(const Place& at) {
  return fail(
      "expected a way whose places the CRS that distances are measured in has, one beside the "
      "other, got one that comes to {}, {}, beside which PROJ finds none, or a seam or a pole of "
      "that CRS is crossed",
      at[0], at[1]);
}

TerrainTin::TerrainTin(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TerrainTin::TerrainTin(TerrainTin&& other) noexcept = default;
TerrainTin::~TerrainTin() = default;

const TerrainReport& TerrainTin::report() const { return impl_->report; }

void TerrainTin::Impl::find_rectangle() {
  if (tin.vertices.empty()) return;
  lower = upper = tin.vertices.front();
  for (const delaunay::LatticePoint& p : tin.vertices) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y)};
  }
}

Result<void> TerrainTin::Impl::find_parts(const Terrain& asked, const TerrainOptions& wanted,
                                          TinUse use, Progress& progress) {
  if (wanted.samples) return {};
  const Stopwatch watch;
  LODE_TRY(auto found, asked.origin().parts(wanted));
  if (!found) return {};
  if (use == TinUse::lines) {
    LODE_TRY(range, found->height_range(progress));
    if (!range) return {};
  }
  parts = std::move(found);
  report = parts->report();
  report.seconds = watch.seconds();
  lower = parts->lower();
  upper = parts->upper();
  terrain = asked;
  options = wanted;
  return {};
}

Result<std::vector<ProfilePoint>> TerrainTin::Impl::profile(const Place& a, const Place& b,
                                                            Progress& progress) const {
  if (patches) return patches->profile(a, b);
  if (!parts) return tin_profile(tin, a, b);
  LODE_TRY(const delaunay::Tin near, parts->along(a, b, progress));
  return tin_profile(near, a, b);
}

Result<TerrainTin> TerrainTin::select(const Terrain& terrain, const TerrainOptions& options,
                                      const HorizontalMetric& metric, Progress& progress,
                                      TinUse use) try {
  auto impl = std::unique_ptr<Impl>(new Impl{terrain.frame(), metric, {}, {}});
  if (use == TinUse::places || use == TinUse::lines) {
    LODE_CHECK(impl->find_parts(terrain, options, use, progress));
    if (impl->parts) return TerrainTin(std::move(impl));
  }
  if (use == TinUse::places) {
    LODE_TRY(impl->patches, terrain.origin().patches(options, progress));
    if (impl->patches) {
      impl->report = impl->patches->report();
      impl->lower = impl->patches->lower();
      impl->upper = impl->patches->upper();
      impl->terrain = terrain;
      return TerrainTin(std::move(impl));
    }
  }
  LODE_TRY(SelectedTerrain selected,
           use == TinUse::triangles
               ? terrain.origin().select_triangles(options, progress)
               : terrain.origin().select(options, delaunay::TinLinks::kept, progress));
  if (options.samples) LODE_CHECK(hold_everywhere(terrain, options, selected, progress));
  impl->report = selected.report;
  impl->tin = std::move(selected.tin);
  impl->find_rectangle();
  return TerrainTin(std::move(impl));
} catch (const std::bad_alloc&) {
  return out_of_memory("select samples");
}

Result<TerrainProfile> TerrainTin::profile(const Place& from, const Place& to,
                                           Progress& progress) const try {
  LODE_CHECK(check_angles(impl_->metric, {{std::min(from[0], to[0]), std::min(from[1], to[1])}},
                          {{std::max(from[0], to[0]), std::max(from[1], to[1])}}));
  if (progress.is_cancelled()) return cancelled_error();
  const Stopwatch watch;
  TerrainProfile profile;
  const auto place_at = [&](double t) { return from * (1 - t) + to * t; };
  // Lengths add up from row to row, so that they never fall.
  Place last = from;
  double distance = 0;
  const auto move_to = [&](const Place& at) {
    distance += impl_->metric.distance(std::exchange(last, at), at);
    return distance;
  };
  const Place a = impl_->to_lattice(from);
  const Place b = impl_->to_lattice(to);
  if (a == b)
    return fail("expected two places that differ by more than rounding, got {}, {} and {}, {}",
                from[0], from[1], to[0], to[1]);
  LODE_TRY(const std::vector<ProfilePoint> points, impl_->profile(a, b, progress));
  double error = 0;
  bool is_step = false;
  for (const ProfilePoint& point : points) {
    const double before = distance;
    const Place at = point.t == 1 ? to : place_at(point.t);
    TerrainProfile::Point row{move_to(at), at, point.height};
    if (point.starts_part && distance > before) profile.gaps.push_back({before, distance});
    const bool is_new = point.starts_part || profile.points.empty();
    row.part = is_new ? (profile.points.empty() ? 1 : profile.points.back().part + 1)
                      : profile.points.back().part;
    row.bound =
        impl_->error_bound(is_new ? point.error : std::max(error, point.error)) + point.rounding;
    error = point.error;
    if (point.is_step) ++profile.n_steps;
    if (is_step)
      profile.largest_step =
          std::max(profile.largest_step, std::abs(row.height - profile.points.back().height));
    is_step = point.is_step;
    profile.points.push_back(row);
  }
  const double before = distance;
  profile.length = move_to(to);
  if (!std::isfinite(profile.length))
    return impl_->not_measured(profile.points.empty() ? from : first_unmeasured(profile, to));
  if (points.empty() || points.back().t < 1) profile.gaps.push_back({before, profile.length});
  profile.seconds = watch.seconds();
  return profile;
} catch (const std::bad_alloc&) {
  return out_of_memory("find the profile");
}

}  // namespace lode
