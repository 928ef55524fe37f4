// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 3: the Delaunay selector.
#include "lode/models/terrain/delaunay_selector/selector.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/grid_cells.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/seams.h"
#include "lode/delaunay/tile_insertion.h"
#include "lode/models/terrain/delaunay_selector/spatial_order.h"

namespace lode::delaunay_selector {
namespace {

delaunay::GreedyOptions greedy_options(const SelectorOptions& options) {
  delaunay::GreedyOptions greedy{
      .max_error = options.max_error, .order = options.order, .threads = options.threads};
  if (options.max_cells) greedy.max_triangles = *options.max_cells;
  return greedy;
}

std::vector<double> heights_of(const delaunay::Tin& tin, const HeightGrid& grid) {
  std::vector<double> heights;
  heights.reserve(tin.vertices.size());
  for (const delaunay::LatticePoint& p : tin.vertices) heights.push_back(grid.height(p.x, p.y));
  return heights;
}

Selection to_selection(delaunay::PointMesh& mesh, const SpatialOrder& order,
                       const PointDomain& domain, delaunay::TinLinks links) {
  mesh.heal();
  Selection selection;
  selection.tin = order.to_tin(mesh, links);
  selection.n_samples = order.nodes.size() - domain.n_left_out;
  selection.n_left_out = domain.n_left_out;
  return selection;
}

Result<Selection> select_in_tiles(const HeightGrid& grid, const SelectorOptions& options,
                                  Progress& progress) {
  const HeightRange range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(range));
  const auto insert = [&](const auto& samples) {
    using T = typename std::decay_t<decltype(samples)>::value_type;
    return delaunay::insert_in_tiles<T>(
        grid, range.lower, range.upper,
        {.max_error = options.max_error, .links = options.links, .threads = options.threads},
        progress);
  };
  LODE_TRY(delaunay::SeamedTiles tiles, std::visit(insert, grid.heights));
  Selection selection;
  selection.tin = delaunay::to_tin(tiles, options.threads);
  selection.tin.heights = heights_of(selection.tin, grid);
  selection.achieved_error = tiles.report.achieved_error;
  selection.n_samples = tiles.n_samples;
  selection.n_left_out = tiles.n_left_out;
  return selection;
}

/// Where a raster that goes round has to have vertices on both its first and its last column.
std::vector<std::int32_t> side_rows(const HeightGrid& grid, const SelectorOptions& options) {
  if (!grid.is_round || options.max_cells || !delaunay::check_lattice(grid)) return {};
  const HeightRange range = height_range(grid);
  const delaunay::LatticePoint last{grid.n_columns - 1, grid.n_rows - 1};
  const auto find = [&](const auto& samples) {
    using T = typename std::decay_t<decltype(samples)>::value_type;
    const delaunay::SampleRows<T> rows{samples.data(), grid.stride,
                                       delaunay::LatticePacking(grid.n_columns)};
    std::optional<delaunay::GridCells> cells;
    if (grid.n_missing() > 0) cells.emplace(grid);
    return delaunay::find_round_side(
        last, rows, cells ? &*cells : nullptr,
        {.range = range.upper - range.lower, .max_error = options.max_error, .turn = last.x});
  };
  return std::visit(find, grid.heights);
}

/// Adds rows of vertices of either column that are not on both sides by then; whether there are
/// such. Rounding of heights that are no integers may ask for them.
bool add_unequal(const delaunay::LatticeMesh& mesh, std::int32_t last,
                 std::vector<std::int32_t>& rows) {
  std::vector<std::int32_t> all;
  for (const delaunay::LatticeTriangle& triangle : mesh.triangles())
    for (const std::uint32_t corner : triangle.corner) {
      const delaunay::LatticePoint p = mesh.nodes().unpack(corner);
      if (p.x == 0 || p.x == last) all.push_back(p.y);
    }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (std::ranges::includes(rows, all)) return false;
  std::vector<std::int32_t> both;
  std::ranges::set_union(rows, all, std::back_inserter(both));
  rows = std::move(both);
  return true;
}

struct Inserted {
  delaunay::GridDomain domain;
  delaunay::LatticeMesh mesh;
  delaunay::GreedyReport report;
};

/// `rows_of_sides`: as of find_domain().
Result<Inserted> insert_samples(const HeightGrid& grid, const SelectorOptions& options,
                                std::span<const std::int32_t> rows_of_sides, Progress& progress) {
  LODE_TRY(delaunay::GridDomain domain, delaunay::find_domain(grid, rows_of_sides));
  const delaunay::LatticePacking packing(grid.n_columns);
  delaunay::LatticeMesh mesh(packing, domain.triangles);
  const HeightRange range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(range));
  const auto insert = [&](const auto& samples) {
    using T = typename std::decay_t<decltype(samples)>::value_type;
    const delaunay::SampleRows<T> rows{samples.data(), grid.stride, packing};
    return delaunay::insert_greedily(mesh, rows, range.lower, range.upper, greedy_options(options),
                                     progress);
  };
  LODE_TRY(const delaunay::GreedyReport report, std::visit(insert, grid.heights));
  return Inserted{std::move(domain), std::move(mesh), report};
}

}  // namespace

Result<Selection> select_samples(const HeightGrid& grid, const SelectorOptions& options,
                                 Progress& progress) {
  LODE_EXPECTS(!options.max_cells || options.order == InsertionOrder::strict);
  if (options.order == InsertionOrder::tiles) return select_in_tiles(grid, options, progress);
  std::vector<std::int32_t> rows = side_rows(grid, options);
  LODE_TRY(Inserted inserted, insert_samples(grid, options, rows, progress));
  while (!rows.empty() && add_unequal(inserted.mesh, grid.n_columns - 1, rows)) {
    LODE_TRY(inserted, insert_samples(grid, options, rows, progress));
  }
  const auto& [domain, mesh, report] = inserted;
  Selection selection{.tin = delaunay::to_tin(mesh, options.links),
                      .achieved_error = report.achieved_error,
                      .is_within_error = report.is_within_error,
                      .n_samples = domain.n_samples,
                      .n_left_out = domain.n_left_out};
  selection.tin.heights = heights_of(selection.tin, grid);
  if (options.max_cells)
    selection.is_within_cells = selection.tin.triangles.size() <= *options.max_cells;
  return selection;
}

Result<Selection> select_points(const HeightPoints& points, const PointDomain& domain,
                                const SelectorOptions& options, Progress& progress) {
  LODE_EXPECTS(!options.max_cells || options.order == InsertionOrder::strict);
  if (options.order == InsertionOrder::tiles)
    return fail(
        "expected levels or the strict order, got tiles, which are of rasters without fixed lines");
  const HeightRange range = height_range(points);
  LODE_CHECK(delaunay::check_heights(range));
  const SpatialOrder order(points, domain);
  delaunay::PointMesh mesh = order.mesh();
  LODE_TRY(
      const delaunay::GreedyReport report,
      delaunay::insert_points(mesh, order.samples(), range, greedy_options(options), progress));
  Selection selection = to_selection(mesh, order, domain, options.links);
  selection.achieved_error = report.achieved_error;
  selection.is_within_error = report.is_within_error;
  if (options.max_cells)
    selection.is_within_cells = selection.tin.triangles.size() <= *options.max_cells;
  return selection;
}

Result<Selection> select_all_points(const HeightPoints& points, const PointDomain& domain,
                                    Progress& progress) {
  LODE_CHECK(delaunay::check_heights(height_range(points)));
  const SpatialOrder order(points, domain);
  delaunay::PointMesh mesh = order.mesh();
  LODE_CHECK(delaunay::insert_all_points(mesh, order.samples(), progress));
  return to_selection(mesh, order, domain, delaunay::TinLinks::kept);
}

Result<Selection> select_all_samples(const HeightGrid& grid) {
  LODE_CHECK(delaunay::check_heights(height_range(grid)));
  LODE_TRY(delaunay::FullTin full, delaunay::to_full_tin(grid));
  Selection selection;
  selection.tin = std::move(full.tin);
  selection.n_samples = selection.tin.vertices.size();
  selection.n_left_out = full.n_left_out;
  return selection;
}

}  // namespace lode::delaunay_selector
