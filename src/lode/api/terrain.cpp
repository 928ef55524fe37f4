#include "lode/api/terrain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "lode/api/point_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/mappers/point_tin_check.h"
#include "lode/mappers/tin_check.h"
#include "lode/mappers/tin_sides.h"
#include "lode/mappers/tin_surface.h"
#include "lode/mappers/tin_window.h"

namespace lode {
namespace {

std::string describe_not_delaunay(const TinFacts& facts) {
  if (facts.n_not_delaunay == 0) return "";
  if (facts.n_on_seams < facts.n_not_delaunay)
    return fmt::format("{} are not", facts.n_not_delaunay);
  return fmt::format(
      "{} are not, all on columns and rows that no triangle crosses, as the order "
      "of insertion \"tiles\" leaves them",
      facts.n_not_delaunay);
}

/// `vertices`: what they are to be; `worst`: where the largest error is.
VerifyReport to_report(const TinFacts& facts, double max_error, TinShape shape,
                       const std::string& worst, const char* vertices = "vertices are samples",
                       bool matches_sides = false) {
  VerifyReport report;
  report.add(vertices, facts.n_vertices, facts.n_off_samples,
             facts.n_off_samples > 0 ? fmt::format("{} are not", facts.n_off_samples)
                                     : fmt::format("heights to within {}", facts.height_offset));
  if (facts.n_off_samples > 0) return report;
  report.add("triangles face up", facts.n_triangles, facts.n_turned,
             facts.n_turned > 0 ? fmt::format("{} do not", facts.n_turned) : "");
  if (facts.n_turned > 0) return report;
  report.add("edges have two sides", facts.n_edges, facts.n_overused,
             facts.n_overused > 0 ? fmt::format("{} have more", facts.n_overused) : "");
  const double cell = facts.n_cells > 0 ? static_cast<double>(facts.doubled_domain_area) /
                                              static_cast<double>(facts.n_cells)
                                        : 2;
  if (shape == TinShape::delaunay)
    report.add(facts.n_lines > 0 ? "other inner edges are Delaunay" : "inner edges are Delaunay",
               facts.n_inner_edges, facts.n_not_delaunay, describe_not_delaunay(facts));
  if (shape == TinShape::tiles)
    report.add("inner edges are Delaunay or on seams", facts.n_inner_edges, facts.n_not_delaunay,
               facts.n_not_delaunay > 0 ? fmt::format("{} are neither", facts.n_not_delaunay)
                                        : fmt::format("{} on seams are not", facts.n_constrained));
  if (facts.n_lines > 0)
    report.add("lines are edges", facts.n_lines, facts.n_broken_lines,
               facts.n_broken_lines > 0 ? fmt::format("{} are broken", facts.n_broken_lines) : "");
  if (facts.is_round && matches_sides)
    report.add("sides have the same vertices, as it goes round", facts.n_side_rows,
               facts.n_unmatched,
               facts.n_unmatched > 0 ? fmt::format("{} rows do not", facts.n_unmatched) : "");
  report.add("the domain is covered once", facts.n_cells > 0 ? facts.n_cells : facts.n_samples,
             facts.is_covered() ? 0 : 1,
             facts.is_covered()
                 ? fmt::format("outline of {} edges", facts.n_border_edges)
                 : fmt::format("area of {} cells, {} border edges off the outline, {} samples in "
                               "no triangle",
                               static_cast<double>(facts.doubled_area) / cell, facts.n_off_outline,
                               facts.n_uncovered));
  report.add("samples are within the error", facts.n_samples, facts.n_beyond,
             fmt::format("worst {} of {} {}{}", facts.worst_error, max_error, worst,
                         facts.n_beyond > 0 ? fmt::format("; {} beyond", facts.n_beyond) : ""));
  return report;
}

/// Leaves of a TIN what meets a box. Fails where nothing does.
Result<TerrainClip> clip_selected(const PlaceBox& box, const HeightFrame& frame,
                                  SelectedTerrain& selected) {
  delaunay::Tin& tin = selected.tin;
  TerrainClip clip{.box = box, .n_triangles = selected.report.triangles};
  keep_in_window(tin, frame, {box.lower, box.upper});
  clip.n_kept = tin.triangles.size();
  selected.report.triangles = tin.triangles.size();
  selected.report.vertices = tin.vertices.size();
  if (clip.n_kept > 0) return clip;
  return fail(
      "clip: expected a box that meets the terrain, in its coordinates, got {} to {}, {} to "
      "{}, which meets none of {} triangles",
      box.lower[0], box.upper[0], box.lower[1], box.upper[1], clip.n_triangles);
}

/// All of a mesh, or the part of it round a box, where that can be had; the report is of all.
Result<SelectedTerrain> select_round(const Terrain& terrain, const TerrainOptions& options,
                                     const PlaceBox& box, Progress& progress) {
  LODE_TRY(const auto parts, terrain.origin().parts(options));
  if (parts) {
    const HeightFrame& frame = terrain.frame();
    Vec<double, 2> lower = frame.lattice(box.lower[0], box.lower[1]);
    Vec<double, 2> upper = lower;
    for (const double x : {box.lower[0], box.upper[0]})
      for (const double y : {box.lower[1], box.upper[1]}) {
        const Vec<double, 2> corner = frame.lattice(x, y);
        for (std::size_t k = 0; k < 2; ++k) {
          lower[k] = std::min(lower[k], corner[k]);
          upper[k] = std::max(upper[k], corner[k]);
        }
      }
    // A column and row more, as places of nodes are rounded.
    LODE_TRY(auto tin,
             parts->within({lower[0] - 1, lower[1] - 1}, {upper[0] + 1, upper[1] + 1}, progress));
    if (tin) return SelectedTerrain{*std::move(tin), parts->report()};
  }
  return terrain.origin().select(options, delaunay::TinLinks::left_out, progress);
}

}  // namespace

Result<SelectedTerrain> select_clipped(const Terrain& terrain, const TerrainOptions& options,
                                       const PlaceBox& box, TerrainClip& clip, Progress& progress) {
  LODE_TRY(SelectedTerrain selected, select_round(terrain, options, box, progress));
  LODE_TRY(clip, clip_selected(box, terrain.frame(), selected));
  return selected;
}

Result<TerrainSurface> extract_terrain(const Terrain& terrain, const TerrainOptions& options,
                                       Progress& progress,
                                       const std::optional<PlaceBox>& clip) try {
  const Stopwatch watch;
  std::optional<TerrainClip> clipped;
  if (clip) clipped.emplace();
  LODE_TRY(SelectedTerrain selected,
           clip ? select_clipped(terrain, options, *clip, *clipped, progress)
                : terrain.origin().select(options, delaunay::TinLinks::left_out, progress));
  TinSurface made = to_surface(selected.tin, terrain.frame());
  TerrainReport report = selected.report;
  report.height_slack = made.height_slack;
  report.position_slack = made.position_slack;
  report.n_turned = made.n_turned;
  if (options.is_closed)
    report.n_one_sided = count_one_sided(selected.tin, 0, terrain.frame().n_columns - 1);
  report.seconds = watch.seconds();
  return TerrainSurface{std::move(made.surface), std::move(made.places), report, clipped};
} catch (const std::bad_alloc&) {
  return out_of_memory("select samples");
}

Result<VerifyReport> verify_terrain(const HeightGrid& grid, const Surface& surface,
                                    const TerrainVerifyOptions& options, Progress& progress) try {
  LODE_TRY(
      const TinFacts facts,
      check_tin(surface, grid,
                {.max_error = options.max_error,
                 .seams = options.shape == TinShape::tiles ? TinSeams::allowed : TinSeams::none,
                 .threads = options.threads,
                 .places = options.places},
                progress));
  return to_report(facts, options.max_error, options.shape,
                   fmt::format("in column {}, row {}", facts.worst.x, facts.worst.y),
                   "vertices are samples", options.matches_sides);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the surface");
}

Result<VerifyReport> verify_sample_tin(const HeightGrid& grid, const delaunay::Tin& tin,
                                       const TerrainVerifyOptions& options, Progress& progress) {
  LODE_EXPECTS(options.shape != TinShape::tiles);
  LODE_TRY(const TinFacts facts,
           check_fine_tin(tin, 1, grid, options.max_error, options.threads, progress));
  return to_report(facts, options.max_error, options.shape,
                   fmt::format("in column {}, row {}", facts.worst.x, facts.worst.y),
                   "vertices are samples", options.matches_sides);
}

Result<VerifyReport> verify_fine_tin(const HeightGrid& grid, const delaunay::Tin& tin,
                                     std::int32_t scale, double max_error, Threads threads,
                                     Progress& progress) {
  const HeightRange range = height_range(grid);
  const double rounding = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
  LODE_TRY(const TinFacts facts,
           check_fine_tin(tin, scale, grid, max_error + rounding, threads, progress));
  return to_report(facts, max_error, TinShape::any,
                   fmt::format("in column {}, row {}", facts.worst.x, facts.worst.y),
                   "vertices are samples, or between two");
}

namespace {

/// `Mesh`: PlacedSurfaceView or delaunay::Tin.
template <typename Mesh>
Result<VerifyReport> verify_of_points(const PointTerrain& terrain, const Mesh& mesh,
                                      const TerrainVerifyOptions& options, Progress& progress) {
  LODE_TRY(const TinFacts facts,
           check_point_tin(mesh, terrain.points, terrain.domain.outline, terrain.domain.lines,
                           terrain.points.nodes.size() - terrain.domain.n_left_out,
                           options.max_error, options.threads, progress));
  const Vec<double, 2> at = terrain.points.world(facts.worst.x, facts.worst.y);
  return to_report(facts, options.max_error, options.shape, fmt::format("at {}, {}", at[0], at[1]));
}

}  // namespace

Result<VerifyReport> verify_point_tin(const PointTerrain& terrain, const delaunay::Tin& tin,
                                      const TerrainVerifyOptions& options, Progress& progress) {
  return verify_of_points(terrain, tin, options, progress);
}

Result<VerifyReport> verify_fine_point_tin(const PointTerrain& terrain, const HeightPoints& fine,
                                           const delaunay::Tin& tin, double max_error,
                                           Threads threads, Progress& progress) {
  const HeightRange range = height_range(fine);
  const double rounding = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
  LODE_TRY(const TinFacts facts,
           check_fine_point_tin(tin, fine, terrain.domain.outline, terrain.domain.lines,
                                fine.nodes.size() - terrain.domain.n_left_out, max_error + rounding,
                                threads, progress));
  const Vec<double, 2> at = fine.world(facts.worst.x, facts.worst.y);
  VerifyReport report =
      to_report(facts, max_error, TinShape::any, fmt::format("at {}, {}", at[0], at[1]));
  // Of what vertices are.
  report.checks.erase(report.checks.begin());
  return report;
}

Result<VerifyReport> verify_terrain(const PointTerrain& terrain, const Surface& surface,
                                    const TerrainVerifyOptions& options, Progress& progress) try {
  return verify_of_points(terrain, PlacedSurfaceView{surface, options.places}, options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the surface");
}

TerrainInfo describe_terrain(const HeightGrid& grid) {
  const HeightRange range = height_range(grid);
  TerrainInfo info{.n_missing = grid.n_missing(),
                   .has_heights = range.lower <= range.upper,
                   .lower = range.lower,
                   .upper = range.upper};
  if (const auto domain = delaunay::find_domain(grid); domain.has_value()) {
    info.n_cells = domain->n_cells;
    info.n_left_out = domain->n_left_out;
  } else {
    info.n_left_out = static_cast<std::uint64_t>(grid.n_samples()) - info.n_missing;
  }
  return info;
}

}  // namespace lode
