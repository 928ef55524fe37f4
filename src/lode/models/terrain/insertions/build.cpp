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
  LODE_TRY(History history, HistoryWriter::begin(grid, domain, model));
  const delaunay::LatticePacking packing(grid.n_columns);
  delaunay::LatticeMesh mesh(packing, domain.triangles, rule_of(model));
  HistoryWriter writer(history);
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
  writer.finish(grid);
  return history;
}

}  // namespace lode::insertions
