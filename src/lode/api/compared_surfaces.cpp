#include "lode/api/compared_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "lode/api/surface_text.h"
#include "lode/mappers/surface_distance.h"
#include "lode/mappers/surface_topology.h"
#include "lode/mappers/surface_turning.h"

namespace lode {

double file_rounding(const Surface& a, const Surface& b) {
  double largest = std::numeric_limits<double>::min();
  double origin = 0;
  for (const Surface* surface : {&a, &b}) {
    for (const Vec3f& p : surface->positions)
      for (const float x : p.v) largest = std::max(largest, std::abs(static_cast<double>(x)));
    for (const double x : surface->origin.v) origin = std::max(origin, std::abs(x));
  }
  return 0x1p-22 * largest + 0x1p-48 * origin;
}

void add_pieces(const Surface& surface, const Surface& other, const char* whose, Threads threads,
                VerifyReport& report) {
  const TopologyOptions options{.threads = threads};
  const ComponentTypes found = component_types(check_topology(surface, options));
  const ComponentTypes wanted = component_types(check_topology(other, options));
  ComponentTypes different;
  std::set_symmetric_difference(found.begin(), found.end(), wanted.begin(), wanted.end(),
                                std::back_inserter(different));
  std::string detail = fmt::format("{} pieces, {} {}", found.size(), wanted.size(), whose);
  if (!different.empty())
    detail += fmt::format("; first difference: Euler number {}, {} boundary loops",
                          different.front()[0], different.front()[1]);
  report.add(fmt::format("components, tunnels and boundaries as {}", whose), found.size(),
             different.size(), std::move(detail));
}

void add_kept_pieces(const Surface& surface, const Surface& before, Threads threads,
                     VerifyReport& report) {
  const TopologyOptions options{.threads = threads};
  const ComponentTypes found = component_types(check_topology(surface, options));
  const ComponentTypes wanted = component_types(check_topology(before, options));
  ComponentTypes added;
  ComponentTypes gone;
  std::ranges::set_difference(found, wanted, std::back_inserter(added));
  std::ranges::set_difference(wanted, found, std::back_inserter(gone));
  const auto n_open = std::ranges::count_if(gone, [](const auto& type) { return type[1] > 0; });
  report.add("components of those before simplification, none open gone", wanted.size(),
             added.size() + static_cast<std::size_t>(n_open),
             fmt::format("{} pieces of {}", found.size(), wanted.size()));
}

Surface part_of(const Surface& surface, double isovalue) {
  Surface part;
  part.origin = surface.origin;
  part.positions = surface.positions;
  for (const auto& t : surface.triangles)
    if (surface.isovalues[t[0]] == isovalue) part.triangles.push_back(t);
  return part;
}

namespace {

/// Of each isovalue by itself, as what is near may be of another one, where vertices tell theirs.
Result<SurfaceDistance> measure_by_isovalue(const Surface& surface, const Surface& other,
                                            const DistanceOptions& options, Progress& progress) {
  std::set<double> isovalues(surface.isovalues.begin(), surface.isovalues.end());
  isovalues.insert(other.isovalues.begin(), other.isovalues.end());
  if (surface.isovalues.empty() || other.isovalues.empty() || isovalues.size() == 1)
    return measure_distance(surface, other, options, progress);
  SurfaceDistance largest;
  const auto raise = [](DistanceBounds& to, const DistanceBounds& by) {
    to.lower = std::max(to.lower, by.lower);
    to.upper = std::max(to.upper, by.upper);
  };
  for (const double isovalue : isovalues) {
    LODE_TRY(
        const SurfaceDistance here,
        measure_distance(part_of(surface, isovalue), part_of(other, isovalue), options, progress));
    raise(largest.from_first, here.from_first);
    raise(largest.from_second, here.from_second);
  }
  return largest;
}

}  // namespace

Result<void> add_distance(const Surface& surface, const Surface& other, const char* whose,
                          double max_distance, Threads threads, Progress& progress,
                          VerifyReport& report) {
  const std::string name = fmt::format("distance from that {} and back", whose);
  if (!surface.lines.empty()) {
    report.add(name, surface.lines.size(), 1, "lines, whose distance is not measured");
    return {};
  }
  constexpr double kAccuracy = 1.0 / 16;
  LODE_TRY(const SurfaceDistance distance,
           measure_by_isovalue(surface, other, {kAccuracy * max_distance, threads}, progress));
  const double allowed = max_distance + file_rounding(surface, other);
  report.add(name, surface.triangles.size() + other.triangles.size(),
             distance.lower() <= allowed ? 0 : 1,
             fmt::format("measured {} and {}, at most {} and {}, of {}", distance.from_first.lower,
                         distance.from_second.lower, distance.from_first.upper,
                         distance.from_second.upper, max_distance));
  return {};
}

const char* level_set_distance_name() {
  return "distance from the level set at full resolution and back";
}

Result<void> note_distance(const Surface& surface, const Surface& level_set, double accuracy,
                           Threads threads, Progress& progress, VerifyReport& report) {
  if (!surface.lines.empty()) return {};
  LODE_TRY(const SurfaceDistance distance,
           measure_by_isovalue(surface, level_set, {accuracy, threads}, progress));
  report.add(level_set_distance_name(), surface.triangles.size() + level_set.triangles.size(), 0,
             fmt::format("measured {} and {}, at most {} and {}; none is promised",
                         distance.from_first.lower, distance.from_second.lower,
                         distance.from_first.upper, distance.from_second.upper));
  return {};
}

namespace {

/// Of the first triangles, about; > 0.
double mean_edge(const Surface& surface) {
  constexpr std::size_t kMost = 1000;
  const std::size_t n = std::min(kMost, surface.triangles.size());
  double sum = 0;
  for (std::size_t t = 0; t < n; ++t)
    sum += length(surface.world_position(surface.triangles[t][1]) -
                  surface.world_position(surface.triangles[t][0]));
  return sum > 0 ? sum / static_cast<double>(n) : 1;
}

}  // namespace

Result<void> add_turning(const Surface& surface, const Surface& before, MayDrop may_drop,
                         std::optional<double> distance, Threads threads, Progress& progress,
                         VerifyReport& report) {
  if (!surface.lines.empty()) return {};
  const PieceFacing found = facing_of(surface, threads);
  const PieceFacing wanted = facing_of(before, threads);
  const std::uint64_t slack = found.n_flat + wanted.n_flat;
  const auto is_wrong = [&](std::uint64_t n, std::uint64_t n_before) {
    return n > n_before + slack || (may_drop == MayDrop::no && n + slack < n_before);
  };
  LODE_TRY(const NearFacing near,
           hold_against(surface, before, distance.value_or(mean_edge(before)), threads, progress));
  constexpr double kMost = 0.75;
  const bool is_told = near.is_large || !distance;
  const bool is_turned = (is_told && near.share_turned > kMost) || near.n_turned > 0 ||
                         is_wrong(found.n_outward, wanted.n_outward) ||
                         is_wrong(found.n_inward, wanted.n_inward);
  std::string detail =
      fmt::format("{} closed ones face outward and {} inward, before {} and {}", found.n_outward,
                  found.n_inward, wanted.n_outward, wanted.n_inward);
  detail += is_told ? fmt::format("; {:.1f} % of all faces another way than what is near",
                                  100 * near.share_turned)
                    : "; all is too small for this distance to say which way it faces";
  if (is_told && found.n_open > 0)
    detail += fmt::format(", and {} of {} large open ones", near.n_turned, near.n_large_open);
  report.add("pieces face the way they did",
             found.n_outward + found.n_inward + found.n_flat + found.n_open, is_turned ? 1 : 0,
             std::move(detail));
  return {};
}

}  // namespace lode
