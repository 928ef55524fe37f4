#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "lode/api/common_nodes.h"
#include "lode/api/compared_surfaces.h"
#include "lode/api/persistence_verification.h"
#include "lode/api/simplification.h"
#include "lode/api/surface_text.h"
#include "lode/api/topology_extraction.h"
#include "lode/api/verification.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/surface_checks.h"
#include "lode/mappers/surface_near.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/boundary_check.h"
#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/cut_check.h"
#include "lode/models/diamond/level_set_check.h"
#include "lode/models/diamond/model_samples.h"
#include "lode/models/diamond/side_check.h"
#include "lode/models/diamond/surface_coordinates.h"

namespace lode {
namespace {

using diamond::Model;

void add_topology(const Surface& surface, const diamond::PinchPlaces& pinches, Threads threads,
                  VerifyReport& report) {
  const TopologyReport t = check_topology(
      surface,
      {.may_pinch = [&](std::uint32_t v) { return pinches.contain(v); }, .threads = threads});
  const auto add_offenders = [&](const char* name, std::uint64_t n, const Offenders& offenders,
                                 const auto& describe) {
    report.add(name, n, offenders.count,
               offenders.count == 0
                   ? "0 bad"
                   : fmt::format("{} bad; first: {}", offenders.count, describe(offenders.first)));
  };
  const auto edge = [&](const auto& e) { return describe_edge(surface, e[0], e[1]); };
  const auto vertex = [&](const auto& v) { return describe_vertex(surface, v[0]); };
  const auto cell = [&](const auto& c) { return describe_cell(surface, c[0]); };
  add_offenders("manifold edges", t.n_edges, t.non_manifold_edges, edge);
  add_offenders("consistent orientation", t.n_edges, t.inconsistent_edges, edge);
  add_offenders("manifold vertices", t.n_used_vertices, t.non_manifold_vertices, vertex);
  add_offenders("no degenerate cell", t.n_simplices, t.degenerate_simplices, cell);
  add_offenders("no unused vertex", surface.positions.size(), t.isolated_vertices, vertex);
  report.add("no duplicate vertex", t.n_used_vertices, t.duplicate_vertices.count,
             t.duplicate_vertices.count == 0
                 ? fmt::format("0 duplicates, {} hole or clip twins", t.n_twins)
                 : fmt::format("{} duplicates; first: vertices {} and {}",
                               t.duplicate_vertices.count, t.duplicate_vertices.first[0],
                               describe_vertex(surface, t.duplicate_vertices.first[1])));
}

/// Cubes of several isovalues may meet, those of one do not.
Result<void> add_crossings(const Surface& surface, const ExtractOptions& options,
                           Progress& progress, VerifyReport& report) {
  std::uint64_t n_candidates = 0;
  std::uint64_t n_meetings = 0;
  std::string first;
  /// `numbers`: of the part's triangles in the surface; empty where it is all of that.
  const auto look_at = [&](const Surface& part,
                           std::span<const std::uint32_t> numbers) -> Result<void> {
    LODE_TRY(const auto found, check_self_intersections(part, options.threads, progress));
    n_candidates += found.n_candidates;
    const auto describe = [&](std::uint32_t i) {
      return describe_cell(surface, numbers.empty() ? i : numbers[i]);
    };
    if (found.n_intersections > 0 && n_meetings == 0)
      first = fmt::format("; first: {} and {}", describe(found.first[0]), describe(found.first[1]));
    n_meetings += found.n_intersections;
    return {};
  };
  const bool is_by_isovalue = options.style == SurfaceStyle::cubes &&
                              options.isovalues.size() > 1 && !surface.isovalues.empty() &&
                              surface.lines.empty();
  if (is_by_isovalue) {
    const std::set<double> isovalues(surface.isovalues.begin(), surface.isovalues.end());
    for (const double isovalue : isovalues) {
      std::vector<std::uint32_t> numbers;
      for (std::uint32_t i = 0; i < surface.triangles.size(); ++i)
        if (surface.isovalues[surface.triangles[i][0]] == isovalue) numbers.push_back(i);
      LODE_CHECK(look_at(part_of(surface, isovalue), numbers));
    }
  } else {
    LODE_CHECK(look_at(surface, {}));
  }
  report.add(is_by_isovalue ? "no self-intersection of any isovalue" : "no self-intersection",
             n_candidates, n_meetings, fmt::format("{} pairs meet{}", n_meetings, first));
  return {};
}

/// What breaks a rule of the level set, or the largest deviation.
std::string describe_level_set(const Surface& surface, const diamond::LevelSetReport& found,
                               double tolerance, double slack) {
  const auto some = [&](const diamond::SimplexOffenders& offenders, const char* what) {
    return fmt::format("{} {}; first: {}", offenders.count, what,
                       describe_cell(surface, offenders.first));
  };
  if (found.outside.count > 0) return some(found.outside, "outside the volume or the clip box");
  if (found.ambiguous_isovalue.count > 0)
    return some(found.ambiguous_isovalue, "with corners of several isovalues");
  if (found.inside_removed.count > 0) return some(found.inside_removed, "inside holes");
  return fmt::format("largest {} of {} + {}, at {}, in {}", found.max_deviation, tolerance, slack,
                     describe_place(found.worst_point),
                     describe_cell(surface, found.worst_simplex));
}

void add_boundary(const Surface& surface, const diamond::BoundaryReport& boundary, bool is_closed,
                  VerifyReport& report) {
  const std::string first =
      boundary.n_stray == 0
          ? ""
          : "; first: " + describe_edge(surface, boundary.first_stray[0], boundary.first_stray[1]);
  if (is_closed)
    report.add("closed but for holes", boundary.n_edges, boundary.n_stray + boundary.n_on_border,
               fmt::format("{} stray edges, {} at the border{}", boundary.n_stray,
                           boundary.n_on_border, first));
  else
    report.add("ends only at the border, holes and clip planes", boundary.n_edges, boundary.n_stray,
               fmt::format("{} stray edges{}", boundary.n_stray, first));
}

constexpr const char* kFullResolution = "at full resolution";
constexpr const char* kUnsimplified = "before simplification";

void add_match(const Surface& expected, const Surface& surface, VerifyReport& report) {
  const MatchReport match = match_surfaces(expected, surface, file_rounding(expected, surface));
  std::string detail;
  if (match.n_missing > 0)
    detail = fmt::format("{} cells missing; first: the query's {}", match.n_missing,
                         describe_cell(expected, match.first_missing));
  else if (match.n_extra > 0)
    detail = fmt::format("{} cells that the query does not make; first: {}", match.n_extra,
                         describe_cell(surface, match.first_extra));
  else if (match.n_turned > 0)
    detail = fmt::format("{} cells turned the other way round; first: {}", match.n_turned,
                         describe_cell(surface, match.first_turned));
  report.add("complete: all that the query makes, turned as it says", match.n_cells,
             match.is_same() ? 0 : 1, std::move(detail));
}

/// Repeats the query and compares it with every sample.
template <int D>
Result<void> add_cut(const Model<D>& model, double isovalue, Threads threads, double tolerance,
                     const diamond::NodeSet<3>* wanted, Progress& progress, VerifyReport& report) {
  diamond::IsosurfaceQuery query{.isovalue = isovalue, .tolerance = tolerance, .threads = threads};
  if constexpr (D == 3) query.wanted = wanted;
  LODE_TRY(const auto cut, diamond::check_cut<D>(model, query, progress));
  const bool is_achieved = cut.achieved_error <= tolerance && cut.n_too_far == 0;
  report.add(fmt::format("F' within the achieved error at {}", isovalue), cut.n_active_samples,
             is_achieved ? 0 : 1,
             fmt::format("largest {} of {}{}{}", cut.largest_difference, cut.achieved_error,
                         cut.n_too_far > 0 ? "; " : "", cut.n_too_far > 0 ? cut.worst : ""));
  report.add(fmt::format("no true surface outside the active simplices at {}", isovalue),
             cut.n_pruned_samples, cut.n_lost,
             cut.n_lost == 0 ? "" : fmt::format("{} simplices; {}", cut.n_lost, cut.worst));
  return {};
}

/// Of all isovalues, which are of one cut where their topology is kept.
Result<CommonNodes> critical_nodes(const Model<3>& model, const ExpectedSurface& expected,
                                   const ExtractOptions& options, Progress& progress) {
  const NodeSearch search{
      .none = [&] { return diamond::NodeSet<3>(model.shape); },
      .critical =
          [&](double isovalue, const diamond::NodeSet<3>& nodes, std::uint64_t /*max_bytes*/) {
            return diamond::find_critical_nodes(model,
                                                {.isovalue = isovalue,
                                                 .persistence = *expected.keep_topology,
                                                 .threads = options.threads,
                                                 .tolerance = expected.tolerance,
                                                 .refined = &nodes},
                                                progress);
          },
      .within_distance = {}};
  ExtractOptions kept = options;
  kept.keep_topology = expected.keep_topology;
  kept.max_distance.reset();
  kept.leaves_out_weak = false;
  ExtractReport report;
  report.max_error = expected.tolerance;
  begin_topology(kept, report);
  return find_common_nodes(kept, search, report, progress);
}

template <int D>
Result<void> add_cuts(const Model<D>& model, const ExpectedSurface& expected,
                      const ExtractOptions& options, Progress& progress, VerifyReport& report) {
  CommonNodes common;
  if constexpr (D == 3)
    if (expected.keep_topology) {
      LODE_TRY(common, critical_nodes(model, expected, options, progress));
    }
  for (const double isovalue : options.isovalues)
    LODE_CHECK(add_cut(model, isovalue, options.threads, expected.tolerance,
                       common.wanted ? &*common.wanted : nullptr, progress, report));
  return {};
}

template <int D>
Result<void> add_level_set(const Model<D>& model, const Surface& surface,
                           const ExpectedSurface& expected, const ExtractOptions& options,
                           Progress& progress, VerifyReport& report) {
  const bool is_closed = options.border == Border::closed;
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const double range = model.stats.max - model.stats.min;
  const double slack = (frame.margin + 4 * frame.rounding) * range;
  const double tolerance = std::max(expected.tolerance, expected.style_error);
  const double more_on_caps = leaves_out_weak(options) ? *options.keep_topology : 0;
  LODE_TRY(
      const auto level_set,
      diamond::check_level_set(diamond::ModelSamples<D>(model), surface,
                               {.isovalues = options.isovalues,
                                .tolerance = tolerance + slack,
                                .clip = options.clip,
                                .caps = is_closed ? diamond::Caps::on_border : diamond::Caps::none,
                                .cap_tolerance = more_on_caps,
                                .threads = options.threads},
                               progress));
  report.add(is_closed ? "|F - isovalue| <= tolerance + slack; on caps isovalue - F"
                       : "|F - isovalue| <= tolerance + slack",
             level_set.n_pieces, level_set.holds() ? 0 : 1,
             describe_level_set(surface, level_set, tolerance, slack) +
                 (is_closed ? fmt::format("; {} caps", level_set.n_caps) : "") +
                 (is_closed && more_on_caps > 0
                      ? fmt::format(", below which {} more, the persistence, may be", more_on_caps)
                      : ""));
  return {};
}

std::string describe_sides(const diamond::SideReport& sides, diamond::SeenFrom asked) {
  const auto describe = [](const Index3& p) { return fmt::format("{},{},{}", p[0], p[1], p[2]); };
  if (sides.n_wrong > 0)
    return fmt::format("{} pairs are not; first: {} and {}", sides.n_wrong,
                       describe(sides.first[0]), describe(sides.first[1]));
  if (asked != diamond::SeenFrom::either || sides.n_pairs == 0) return "";
  return fmt::format("counter-clockwise seen from {} values",
                     sides.seen_from == diamond::SeenFrom::lower_values ? "lower" : "higher");
}

template <int D>
Result<void> add_sides(const Model<D>& model, const Surface& surface,
                       const diamond::SideOptions& options, Progress& progress,
                       VerifyReport& report) {
  LODE_TRY(const auto sides,
           diamond::check_sides(diamond::ModelSamples<D>(model), surface, options, progress));
  report.add(options.reach == Index3{} ? "samples beyond the tolerance on their sides"
                                       : "samples beyond the distance on their sides",
             sides.n_pairs, sides.n_wrong, describe_sides(sides, options.seen_from));
  return {};
}

/// Compares a simplified surface with what it was, and its distance with full resolution, where
/// what it was is not just that (`full` is null else).
Result<void> add_held_to(const Surface& surface, const Surface& before, const Surface* full,
                         bool is_in_band, const ExtractOptions& options, Progress& progress,
                         VerifyReport& report) {
  const bool may_drop = is_in_band && drops_components(options);
  if (may_drop)
    add_kept_pieces(surface, before, options.threads, report);
  else
    add_pieces(surface, before, kUnsimplified, options.threads, report);
  LODE_CHECK(add_turning(surface, before, may_drop ? MayDrop::yes : MayDrop::no,
                         options.simplify_distance, options.threads, progress, report));
  if (!options.simplify_distance) return {};
  const char* const what = full != nullptr ? kFullResolution : kUnsimplified;
  return add_distance(surface, full != nullptr ? *full : before, what, *options.simplify_distance,
                      options.threads, progress, report);
}

/// Triangles between vertices that are inside are, too.
void add_domain(const RegularGrid& grid, const Surface& surface, const ExtractOptions& options,
                VerifyReport& report) {
  const auto clip = grid.has_world_axes() ? options.clip : std::nullopt;
  const diamond::SurfaceCoordinates coordinates(grid, surface, clip, options.threads);
  std::uint64_t n_outside = 0;
  std::uint32_t first = 0;
  for (std::uint32_t v = 0; v < coordinates.size(); ++v)
    if (coordinates.is_outside(v) && n_outside++ == 0) first = v;
  std::string detail;
  if (n_outside > 0) {
    const Vec3d p = surface.world_position(first);
    detail = fmt::format("{} outside; first: {}, {}, {}", n_outside, p[0], p[1], p[2]);
  }
  report.add("vertices in the volume", coordinates.size(), n_outside, std::move(detail));
}

diamond::SeenFrom seen_from(const ExtractOptions& options) {
  return options.orientation == Orientation::from_lower_values ? diamond::SeenFrom::lower_values
                                                               : diamond::SeenFrom::higher_values;
}

/// Of what was simplified within a distance of a level set, or of one that has a tolerance: samples
/// that are farther from it are on their sides, and it faces them.
template <int D>
Result<void> add_far_sides(const Model<D>& model, const Surface& surface,
                           const ExpectedSurface& expected, const ExtractOptions& options,
                           Progress& progress, VerifyReport& report) {
  constexpr const char* kName = "samples beyond the distance on their sides";
  const char* const why = options.isovalues.size() > 1 ? "not looked at of several isovalues"
                          : options.min_component > 1
                              ? "not looked at where small pieces are left out"
                          : options.clip      ? "not looked at where it is cropped"
                          : model.has_holes() ? "not looked at with holes, whose rims may move"
                                              : nullptr;
  if (why != nullptr) {
    report.skip(kName, why);
    return {};
  }
  const RegularGrid& grid = model.info.grid;
  const Surface& before = expected.max_distance > 0 && expected.full_resolution != nullptr
                              ? *expected.full_resolution
                              : expected.surface;
  const double distance =
      (options.simplify_distance.value_or(0) + expected.max_distance) * (1 + 1e-9) +
      file_rounding(surface, before);
  const Mat3 to_index = cofactors(grid.index_to_world_matrix());
  const double size = std::abs(determinant(grid.index_to_world_matrix()));
  Index3 reach;
  for (std::size_t i = 0; i < 3; ++i) {
    // A step along the axis is at least so long across the others.
    const double steps = distance * length(to_index.column(i)) / size;
    reach[i] = static_cast<std::int32_t>(std::min(std::ceil(steps), 1e6));
  }
  const double tolerance = std::isfinite(expected.tolerance) ? expected.tolerance : 0;
  const double persistence = leaves_out_weak(options) ? *options.keep_topology : 0;
  const SurfaceNear near(before, distance);
  return add_sides(model, surface,
                   {.isovalue = options.isovalues.front(),
                    .error = std::max(tolerance, persistence),
                    .reach = reach,
                    .is_far = [&](const Vec3d& p) { return !near.is_within(p); },
                    .seen_from = seen_from(options),
                    .has_holes = model.has_holes(),
                    .threads = options.threads},
                   progress, report);
}

template <int D>
Result<void> add_simplified(const Model<D>& model, const Surface& surface,
                            const ExpectedSurface& expected, const ExtractOptions& options,
                            Progress& progress, VerifyReport& report) {
  const bool is_in_band = has_band(options, expected.tolerance);
  if (is_in_band) {
    LODE_CHECK(add_level_set(model, surface, expected, options, progress, report));
  } else {
    add_domain(model.info.grid, surface, options, report);
  }
  // Cubes of coarse cells are near no others.
  const Surface* const full =
      is_in_band && options.style == SurfaceStyle::tetra ? expected.full_resolution : nullptr;
  // Piece by piece it starts from full resolution in place of half of the error.
  VerifyReport first;
  for (const Surface* before : {&expected.surface, expected.full_resolution}) {
    if (before == nullptr) continue;
    VerifyReport held;
    LODE_CHECK(add_held_to(surface, *before, full, is_in_band, options, progress, held));
    const bool holds = held.passed();
    if (holds || first.checks.empty()) first = std::move(held);
    if (holds) break;
  }
  std::ranges::move(first.checks, std::back_inserter(report.checks));
  if (is_in_band) {
    LODE_CHECK(add_sides(model, surface,
                         {.isovalue = options.isovalues.front(),
                          .error = expected.tolerance,
                          .seen_from = seen_from(options),
                          .has_holes = model.has_holes(),
                          .threads = options.threads},
                         progress, report));
  } else {
    LODE_CHECK(add_far_sides(model, surface, expected, options, progress, report));
  }
  if (expected.keep_topology.value_or(0) == 0) return {};
  return add_persistent(diamond::ModelSamples<D>(model), model.has_holes(), surface,
                        before_simplification(options, expected.tolerance), progress, report);
}

/// How far what comes of cubes and the level set are from each other: nothing is promised of it.
template <int D>
Result<VerifyReport> note_cubes(const Model<D>& model, const Surface& surface,
                                const ExpectedSurface& expected, const ExtractOptions& options,
                                Progress& progress, VerifyReport report) {
  constexpr double kAccuracy = 1.0 / 32;  // of a sample's width
  if (options.style != SurfaceStyle::cubes) return report;
  if (expected.level_set == nullptr) {
    report.skip(level_set_distance_name(), options.min_component > 1
                                               ? "not measured where small pieces are left out"
                                               : "not measured but within a max error of 0");
    return report;
  }
  const double width = std::ranges::min(model.info.grid.spacing.v);
  LODE_CHECK(note_distance(surface, *expected.level_set, kAccuracy * width, options.threads,
                           progress, report));
  return report;
}

}  // namespace

template <int D>
Result<VerifyReport> verify_model_surface(const Model<D>& model, const Surface& surface,
                                          const ExpectedSurface& expected,
                                          const ExtractOptions& options, Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_well_formed(surface));
  const bool is_closed = options.border == Border::closed;
  const diamond::ModelSamples<D> samples(model);
  const diamond::BoundaryOptions ends{.clip = options.clip, .threads = options.threads};
  add_topology(surface, diamond::PinchPlaces(samples, surface, ends), options.threads, report);
  LODE_CHECK(add_crossings(surface, options, progress, report));
  if (options.simplify != Simplify::off) {  // no level set any more, but near one
    LODE_CHECK(add_simplified(model, surface, expected, options, progress, report));
    diamond::BoundaryOptions planes = ends;
    planes.goes_along_planes = model.has_holes();
    LODE_TRY(const auto boundary, diamond::check_boundary(samples, surface, planes, progress));
    add_boundary(surface, boundary, is_closed, report);
    return note_cubes(model, surface, expected, options, progress, std::move(report));
  }
  LODE_CHECK(add_level_set(model, surface, expected, options, progress, report));
  LODE_TRY(const auto boundary, diamond::check_boundary(samples, surface, ends, progress));
  add_boundary(surface, boundary, is_closed, report);
  add_match(expected.surface, surface, report);
  if (expected.keep_topology.value_or(1) == 0)
    add_pieces(surface, *expected.full_resolution, kFullResolution, options.threads, report);
  else if (expected.keep_topology)
    LODE_CHECK(add_persistent(samples, model.has_holes(), surface, options, progress, report));
  if (expected.max_distance > 0) {
    LODE_CHECK(add_distance(surface, *expected.full_resolution, kFullResolution,
                            expected.max_distance, options.threads, progress, report));
    return report;
  }
  LODE_CHECK(add_cuts(model, expected, options, progress, report));
  return note_cubes(model, surface, expected, options, progress, std::move(report));
}

template Result<VerifyReport> verify_model_surface<2>(const Model<2>&, const Surface&,
                                                      const ExpectedSurface&, const ExtractOptions&,
                                                      Progress&);
template Result<VerifyReport> verify_model_surface<3>(const Model<3>&, const Surface&,
                                                      const ExpectedSurface&, const ExtractOptions&,
                                                      Progress&);

template <int D>
Result<VerifyReport> verify_surface_bound(const Model<D>& model, const Surface& surface,
                                          const BoundOptions& options, Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_well_formed(surface));
  const diamond::ModelSamples<D> samples(model);
  const ExtractOptions alike{.isovalues = {options.isovalue}, .threads = options.threads};
  add_topology(surface, diamond::PinchPlaces(samples, surface, {.threads = options.threads}),
               options.threads, report);
  LODE_CHECK(add_crossings(surface, alike, progress, report));
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const double slack = (frame.margin + 4 * frame.rounding) * (model.stats.max - model.stats.min);
  LODE_TRY(const auto level_set, diamond::check_level_set(samples, surface,
                                                          {.isovalues = alike.isovalues,
                                                           .tolerance = options.error + slack,
                                                           .boxes = options.boxes,
                                                           .threads = options.threads},
                                                          progress));
  const char* const name = options.boxes.empty() ? "|F - isovalue| <= bound + slack"
                                                 : "|F - isovalue| <= bound + slack in the boxes";
  if (level_set.n_pieces == 0)
    report.skip(name, options.boxes.empty() ? "there is no surface" : "no surface is in the boxes");
  else
    report.add(name, level_set.n_pieces, level_set.holds() ? 0 : 1,
               describe_level_set(surface, level_set, options.error, slack));
  if constexpr (D == 3)
    LODE_CHECK(add_sides(model, surface,
                         {.isovalue = options.isovalue,
                          .error = options.error,
                          .seen_from = diamond::SeenFrom::either,
                          .has_holes = model.has_holes(),
                          .boxes = options.boxes,
                          .threads = options.threads},
                         progress, report));
  LODE_TRY(const auto boundary,
           diamond::check_boundary(samples, surface,
                                   {.boxes = options.boxes, .threads = options.threads}, progress));
  add_boundary(surface, boundary, false, report);
  return report;
}

template Result<VerifyReport> verify_surface_bound<2>(const Model<2>&, const Surface&,
                                                      const BoundOptions&, Progress&);
template Result<VerifyReport> verify_surface_bound<3>(const Model<3>&, const Surface&,
                                                      const BoundOptions&, Progress&);

}  // namespace lode
