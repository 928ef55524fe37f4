// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), sections 7.1 and 8, figures 14
// and 19: the ternary triangulation and the Delaunay pyramid.
#include "lode/models/terrain/insertions/build.h"

#include <type_traits>
#include <variant>

#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/insertions/recorder.h"

namespace lode::insertions {
namespace {

using delaunay::LatticeMesh;

/// Writes down what greedy insertion does, and what it knows of errors.
class Observer final : public delaunay::InsertionObserver {
 public:
  explicit Observer(History& history) : history_(history), recorder_(history) {}

  void on_start(const LatticeMesh& mesh) override {
    recorder_.start(mesh);
    for (std::size_t t = 0; t < history_.triangles.size(); ++t)
      history_.triangles[t].error = delaunay::to_coarse_above(mesh.triangles()[t].error);
  }
  void on_insertion(const LatticeMesh& mesh, std::uint32_t node,
                    std::span<const std::uint32_t> slots, std::size_t n_removed) override {
    recorder_.add_node(mesh, mesh.nodes().unpack(node), slots, n_removed);
    std::size_t t = history_.triangles.size() - slots.size();
    for (const std::uint32_t slot : slots)
      history_.triangles[t++].error = delaunay::to_coarse_above(mesh.triangles()[slot].error);
  }
  void finish() { recorder_.finish(); }

 private:
  History& history_;
  Recorder recorder_;
};

}  // namespace

Result<History> build_history(const HeightGrid& grid, double max_error,
                              delaunay::InsertionRule rule, Progress& progress) {
  LODE_TRY(const delaunay::GridDomain domain, delaunay::find_domain(grid));
  History history;
  history.rule = rule;
  history.frame = grid;
  history.range = height_range(grid);
  LODE_CHECK(delaunay::check_heights(history.range));
  history.n_samples = domain.n_samples;
  history.n_missing = grid.n_missing();
  history.n_left_out = domain.n_left_out;
  const delaunay::LatticePacking packing(grid.n_columns);
  LatticeMesh mesh(packing, domain.triangles, rule);
  Observer observer(history);
  const auto insert = [&](const auto& samples) {
    using T = typename std::decay_t<decltype(samples)>::value_type;
    const delaunay::SampleRows<T> rows{samples.data(), grid.stride, packing};
    return delaunay::insert_greedily(
        mesh, rows, history.range.lower, history.range.upper,
        {.max_error = max_error, .order = delaunay::InsertionOrder::strict, .observer = &observer},
        progress);
  };
  LODE_TRY(const delaunay::GreedyReport report, std::visit(insert, grid.heights));
  history.max_error = report.achieved_error;
  observer.finish();
  history.heights.reserve(history.vertices.size());
  for (const delaunay::LatticePoint& p : history.vertices)
    history.heights.push_back(grid.height(p.x, p.y));
  return history;
}

}  // namespace lode::insertions
