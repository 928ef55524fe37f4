#include "lode/api/built_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>

#include "lode/api/point_terrain.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/mappers/tin_quality.h"

namespace lode {

Result<SelectedTerrain> BuiltModel::select_all(Progress& /*progress*/) const {
  return fail(
      "expected a raster, points, or a model that keeps all heights of its raster (the quadtrees, "
      "the quaternary triangulation, right_triangle_bisection, the implicit Delaunay pyramid), got "
      "{}, which keeps those of its vertices",
      name_of(model()));
}

Result<VerifyReport> BuiltModel::verify(const PointTerrain& /*terrain*/, Threads /*threads*/,
                                        Progress& /*progress*/) const {
  return fail("expected the raster that the {} was built of, got points, or lines with it",
              name_of(model()));
}

void count_selection(const terrain_file::Source& source, SelectedTerrain& selected) {
  selected.report.triangles = selected.tin.triangles.size();
  selected.report.vertices = selected.tin.vertices.size();
  selected.report.n_samples = source.n_samples;
  selected.report.n_missing = source.n_missing;
  selected.report.n_left_out = source.n_left_out;
}

void report_focus(const TerrainDemand& focus, const HeightFrame& frame, SelectedTerrain& selected) {
  TerrainReport& report = selected.report;
  report.is_uniform = false;
  report.view = focus.measure(selected.tin, frame);
  report.is_within_error = !report.view || report.view->is_within_error();
  report.is_focus_empty = !focus.meets_terrain();
}

namespace {

/// Of what the model says of its origin, and whether it is so.
struct Said {
  const char* what;
  bool holds;
};

void report_said(std::span<const Said> all, const char* name, VerifyReport& report) {
  std::string wrong;
  for (const Said& said : all)
    if (!said.holds) wrong += fmt::format("{}{}", wrong.empty() ? "" : ", ", said.what);
  report.add(name, all.size(), wrong.empty() ? 0 : 1, wrong.empty() ? "" : "not so: " + wrong);
}

bool is_same_place(const HeightFrame& a, const HeightFrame& b) { return a.to_world == b.to_world; }

bool is_same_range(const HeightRange& a, const HeightRange& b) {
  return a.lower == b.lower && a.upper == b.upper;
}

}  // namespace

Result<void> check_source(const terrain_file::Source& source, const PointTerrain& terrain,
                          VerifyReport& report) {
  if (!source.is_of_points)
    return fail("expected the raster that it was built of, without lines, got points");
  const HeightPoints& points = terrain.points;
  // Where points of another choice lie on another lattice nothing else can be right.
  if (!is_same_place(source.frame, points) || source.frame.n_columns != points.n_columns ||
      source.frame.n_rows != points.n_rows)
    return fail(
        "expected what it was built of, read as it was, on a lattice of {} x {} nodes from {}, "
        "{}, got one of {} x {} from {}, {}",
        source.frame.n_columns, source.frame.n_rows, source.frame.to_world[0],
        source.frame.to_world[3], points.n_columns, points.n_rows, points.to_world[0],
        points.to_world[3]);
  const std::array said{
      Said{"CRS", source.frame.crs == points.crs},
      Said{"unit", source.frame.vertical_unit == points.vertical_unit},
      Said{"range", is_same_range(source.range, height_range(points))},
      Said{"points", source.n_samples == points.nodes.size() - terrain.domain.n_left_out},
      Said{"missing", source.n_missing == terrain.n_missing},
      Said{"left out", source.n_left_out == terrain.domain.n_left_out + terrain.n_in_no_cell}};
  report_said(said, "the file says of the points what they are", report);
  return {};
}

Result<void> check_source(const terrain_file::Source& source, const HeightGrid& grid,
                          VerifyReport& report) {
  if (source.is_of_points)
    return fail(
        "expected the points, or the raster with its lines, that it was built of, got a raster "
        "without");
  if (source.frame.n_columns != grid.n_columns || source.frame.n_rows != grid.n_rows)
    return fail("expected the raster that it was built of, {} x {} samples, got one of {} x {}",
                source.frame.n_columns, source.frame.n_rows, grid.n_columns, grid.n_rows);
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  const std::array said{Said{"place", is_same_place(source.frame, grid)},
                        Said{"CRS", source.frame.crs == grid.crs},
                        Said{"unit", source.frame.vertical_unit == grid.vertical_unit},
                        Said{"range", is_same_range(source.range, height_range(grid))},
                        Said{"samples", source.n_samples == domain.n_samples},
                        Said{"missing", source.n_missing == grid.n_missing()},
                        Said{"left out", source.n_left_out == domain.n_left_out}};
  report_said(said, "the file says of the raster what it is", report);
  return {};
}

void check_stored_heights(const HeightGrid& own, const HeightGrid& grid, VerifyReport& report) {
  std::uint64_t n_other = 0;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const bool has = grid.has_height(x, y);
      if (has != own.has_height(x, y) || (has && grid.height(x, y) != own.height(x, y))) ++n_other;
    }
  report.add("heights are the raster's", static_cast<std::uint64_t>(grid.n_samples()), n_other,
             n_other > 0 ? fmt::format("{} are others", n_other) : "");
}

std::uint64_t count_lost(const std::vector<LatticePoint>& nodes, const delaunay::Tin& tin) {
  const auto is_before = [](LatticePoint a, LatticePoint b) {
    return std::pair(a.y, a.x) < std::pair(b.y, b.x);
  };
  std::vector<LatticePoint> vertices = tin.vertices;
  std::ranges::sort(vertices, is_before);
  return static_cast<std::uint64_t>(std::ranges::count_if(
      nodes, [&](LatticePoint p) { return !std::ranges::binary_search(vertices, p, is_before); }));
}

double plane_rounding(const HeightGrid& grid) {
  const HeightRange range = height_range(grid);
  return 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
}

Result<std::uint64_t> count_understated(const delaunay::Tin& tin, std::int32_t scale,
                                        const HeightGrid& grid, double rounding, Threads threads,
                                        Progress& progress) {
  std::atomic<std::uint64_t> n_beyond = 0;
  constexpr std::size_t kAtOnce = 256;
  parallel_for(tin.triangles.size(), threads, kAtOnce, [&](std::size_t t, int) {
    if (progress.is_cancelled()) return;
    const auto stated = static_cast<double>(tin.errors[t]);
    if (worst_error_in(tin, t, scale, grid) > stated + rounding) ++n_beyond;
  });
  if (progress.is_cancelled()) return cancelled_error();
  return n_beyond.load();
}

Result<void> check_stated_errors(const delaunay::Tin& tin, std::int32_t scale,
                                 const HeightGrid& grid, const char* name, Threads threads,
                                 Progress& progress, VerifyReport& report) {
  LODE_TRY(const std::uint64_t n_beyond,
           count_understated(tin, scale, grid, plane_rounding(grid), threads, progress));
  report.add(name, tin.triangles.size(), n_beyond,
             n_beyond > 0 ? fmt::format("{} have samples that err by more", n_beyond) : "");
  return {};
}

Result<terrain_file::Source> source_of(const HeightGrid& grid, const TerrainBuildOptions& options) {
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  terrain_file::Source source;
  source.frame = grid;
  source.range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(source.range));
  source.sample_type = options.sample_type;
  source.has_place = options.has_place;
  source.n_samples = domain.n_samples;
  source.n_missing = grid.n_missing();
  source.n_left_out = domain.n_left_out;
  return source;
}

double largest_error(const delaunay::Tin& tin) {
  return tin.errors.empty() ? 0.0 : static_cast<double>(*std::ranges::max_element(tin.errors));
}

}  // namespace lode
