// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), sections 7.1 and 8, figures 14
// and 19: the ternary triangulation and the Delaunay pyramid.
#include "lode/models/terrain/insertions/build.h"

#include <type_traits>
#include <variant>

#include "lode/core/expects.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/models/terrain/insertions/history_writer.h"

namespace lode::insertions {

Result<History> build_history(const HeightGrid& grid, double max_error, Model model,
                              Progress& progress) {
  LODE_EXPECTS(model != Model::implicit_delaunay_pyramid);
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  LODE_TRY(History history, begin_history(grid, domain, model));
  const delaunay::LatticePacking packing(grid.n_columns);
  delaunay::LatticeMesh mesh(packing, domain.triangles, rule_of(model));
  HistoryWriter<delaunay::LatticePacking> writer(history);
  const auto insert = [&](const auto& samples) {
    using T = typename std::decay_t<decltype(samples)>::value_type;
    const delaunay::SampleRows<T> rows{samples.data(), grid.stride, packing};
    return delaunay::insert_greedily(
        mesh, rows, history.range.lower, history.range.upper,
        {.max_error = max_error, .order = delaunay::InsertionOrder::strict, .observer = &writer},
        progress);
  };
  LODE_TRY(const delaunay::GreedyReport report, std::visit(insert, grid.heights));
  history.max_error = report.achieved_error;
  writer.finish([&](std::uint32_t node) {
    const delaunay::LatticePoint p = packing.unpack(node);
    return grid.height(p.x, p.y);
  });
  return history;
}

Result<History> build_history(const PointGround& ground, double max_error, Model model,
                              Progress& progress) {
  LODE_EXPECTS(model != Model::implicit_delaunay_pyramid);
  LODE_TRY(History history, begin_history(ground, model));
  delaunay::PointMesh mesh = make_mesh(ground, model);
  HistoryWriter<delaunay::ListedNodes> writer(history);
  LODE_TRY(
      const delaunay::GreedyReport report,
      delaunay::insert_points(mesh, ground.samples, history.range,
                              {.max_error = max_error, .order = delaunay::InsertionOrder::strict},
                              progress, &writer));
  history.max_error = report.achieved_error;
  writer.finish([&](std::uint32_t node) { return ground.samples.heights[node]; });
  history.lines = lines_between(ground, writer.nodes().first(history.n_base_vertices));
  return history;
}

}  // namespace lode::insertions
