// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), sections 7.1 and 8, figures 14
// and 19: the ternary triangulation and the Delaunay pyramid.
#include "lode/models/terrain/insertions/build.h"

#include <algorithm>
#include <type_traits>
#include <unordered_map>
#include <variant>
#include <vector>

#include "lode/core/expects.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/models/terrain/insertions/history_writer.h"

namespace lode::insertions {
namespace {

/// Those of the lines that have a triangle on both sides, as the history numbers their ends.
/// Sorted.
std::vector<std::array<std::uint32_t, 2>> lines_between(const PointGround& ground,
                                                        std::span<const std::uint32_t> nodes) {
  const auto key = [](std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  };
  std::unordered_map<std::uint64_t, int> n_sides;
  for (const auto& [a, b] : ground.lines) n_sides[key(a, b)] = 0;
  for (const auto& corner : ground.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (const auto found = n_sides.find(key(corner[i], corner[(i + 1) % 3]));
          found != n_sides.end())
        ++found->second;
  std::unordered_map<std::uint32_t, std::uint32_t> vertex_of;
  for (std::uint32_t v = 0; v < nodes.size(); ++v) vertex_of.emplace(nodes[v], v);
  std::vector<std::array<std::uint32_t, 2>> lines;
  for (const auto& [ends, n] : n_sides) {
    if (n < 2) continue;
    const std::uint32_t a = vertex_of.at(static_cast<std::uint32_t>(ends >> 32));
    const std::uint32_t b = vertex_of.at(static_cast<std::uint32_t>(ends));
    lines.push_back({std::min(a, b), std::max(a, b)});
  }
  std::ranges::sort(lines);
  return lines;
}

}  // namespace

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
  History history;
  history.model = model;
  history.is_of_points = true;
  history.frame = ground.frame;
  history.range = ground.range;
  LODE_CHECK(delaunay::check_heights(history.range));
  history.n_samples = ground.samples.nodes.size() - ground.n_left_out;
  history.n_left_out = ground.n_left_out;
  delaunay::PointMesh mesh(delaunay::ListedNodes(ground.samples.nodes), ground.triangles,
                           rule_of(model));
  // Edges of triangles that are split stay without being cut.
  if (rule_of(model) == delaunay::InsertionRule::delaunay) mesh.cut(ground.lines);
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
