#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "lode/api/bisection_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "lode/models/terrain/right_triangle_bisection/nested_errors.h"

namespace lode {
namespace {

using bisection::Bisection;
using bisection::Diamond;
using bisection::Lattice;

/// The triangles of the diamonds of some nodes, with the errors that these state.
class DiamondTriangles {
 public:
  DiamondTriangles(const Bisection& tree, const HeightGrid& grid) : tree_(tree), grid_(grid) {}

  /// Nothing of those that the outline passes, or that lie outside of it.
  void add(LatticePoint node) {
    const Lattice& lattice = tree_.lattice();
    const float error = tree_.error(node);
    if (std::isinf(error) || !is_in_domain(node)) return;
    const Diamond diamond(node);
    for (const bool is_left : {true, false}) {
      const LatticePoint apex = diamond.apexes[is_left ? 0 : 1];
      if (!lattice.has(apex)) continue;
      const LatticePoint a = lattice.place(diamond.ends[is_left ? 0 : 1]);
      const LatticePoint b = lattice.place(diamond.ends[is_left ? 1 : 0]);
      const LatticePoint c = lattice.place(apex);
      if (delaunay::doubled_area(a, b, c) <= 0) continue;
      const auto first = static_cast<std::uint32_t>(tin_.vertices.size());
      for (const LatticePoint p : {a, b, c}) {
        tin_.vertices.push_back(p);
        tin_.heights.push_back(grid_.height(p.x, p.y));
      }
      tin_.triangles.push_back({first, first + 1, first + 2});
      tin_.errors.push_back(error);
    }
  }
  [[nodiscard]] const delaunay::Tin& tin() const { return tin_; }
  void clear() { tin_ = {}; }

 private:
  /// As all of its cells are, or none.
  [[nodiscard]] bool is_in_domain(LatticePoint node) const {
    const LatticePoint last = tree_.lattice().last();
    return tree_.has_cell(
        {std::clamp(node.x - 1, 0, last.x - 1), std::clamp(node.y - 1, 0, last.y - 1)});
  }

  const Bisection& tree_;
  const HeightGrid& grid_;
  delaunay::Tin tin_;
};

/// visit(node) of all nodes whose diamonds have some area, calling pause() now and then.
template <typename Visit, typename Pause>
Result<void> visit_nodes(const Lattice& lattice, const Visit& visit, const Pause& pause) {
  for (std::int32_t reach = 1; 2 * reach <= lattice.side(); reach *= 2)
    for (const auto kind : {bisection::NodeKind::side, bisection::NodeKind::square})
      for (std::int32_t y = 0; y <= lattice.side() && y - reach < lattice.last().y; y += reach) {
        const std::int32_t first = bisection::first_column(y, reach, kind);
        for (std::int32_t x = first;
             first >= 0 && x <= lattice.side() && x - reach < lattice.last().x; x += 2 * reach)
          visit(LatticePoint{x, y});
        LODE_CHECK(pause());
      }
  return {};
}

Result<void> check_errors(const Bisection& tree, const HeightGrid& grid, Threads threads,
                          Progress& progress, VerifyReport& report) {
  constexpr std::size_t kAtOnce = 1 << 16;
  const double rounding = plane_rounding(grid);
  DiamondTriangles triangles(tree, grid);
  std::uint64_t n = 0;
  std::uint64_t n_beyond = 0;
  const auto look = [&]() -> Result<void> {
    n += triangles.tin().triangles.size();
    LODE_TRY(const std::uint64_t n_more,
             count_understated(triangles.tin(), 1, grid, rounding, threads, progress));
    n_beyond += n_more;
    triangles.clear();
    return {};
  };
  LODE_CHECK(visit_nodes(
      tree.lattice(), [&](LatticePoint node) { triangles.add(node); },
      [&]() -> Result<void> {
        if (triangles.tin().triangles.size() < kAtOnce) return {};
        return look();
      }));
  LODE_CHECK(look());
  report.add(
      "nodes state their errors", n, n_beyond,
      n_beyond > 0 ? fmt::format("{} triangles have samples that err by more", n_beyond) : "");
  return {};
}

/// Whether no node errs by less than one that waits for it.
Result<void> check_nesting(const Bisection& tree, Progress& progress, VerifyReport& report) {
  const Lattice& lattice = tree.lattice();
  std::uint64_t n = 0;
  std::uint64_t n_less = 0;
  LODE_CHECK(visit_nodes(
      lattice,
      [&](LatticePoint node) {
        const Diamond diamond(node);
        for (const LatticePoint apex : diamond.apexes) {
          if (!lattice.has_node(apex, diamond.apex_reach())) continue;
          ++n;
          if (tree.error(apex) < tree.error(node)) ++n_less;
        }
      },
      [&]() -> Result<void> {
        if (progress.is_cancelled()) return cancelled_error();
        return {};
      }));
  report.add(
      "errors are nested", n, n_less,
      n_less > 0 ? fmt::format("{} nodes err by less than one that waits for them", n_less) : "");
  return {};
}

}  // namespace

Result<VerifyReport> BisectionTerrain::verify(const HeightGrid& grid, Threads threads,
                                              Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(source(), grid, report));
  check_stored_heights(model_.grid, grid, report);
  LODE_CHECK(check_errors(model_.tree, model_.grid, threads, progress, report));
  LODE_CHECK(check_nesting(model_.tree, progress, report));
  for (const double tolerance : model_.levels) {
    const auto name = [&](const std::string& what) {
      return fmt::format("within {}: {}", tolerance, what);
    };
    const delaunay::Tin tin = tin_within(model_.tree, model_.grid, tolerance);
    const auto& kept = model_.tree.kept();
    if (!kept.empty()) {
      const std::uint64_t n_lost = count_lost(kept, tin);
      report.add(name("kept samples are vertices"), kept.size(), n_lost,
                 n_lost > 0 ? fmt::format("{} are not", n_lost) : "");
    }
    LODE_TRY(const VerifyReport level,
             verify_sample_tin(grid, tin,
                               {.max_error = tolerance, .shape = TinShape::any, .threads = threads},
                               progress));
    for (const VerifyReport::Check& check : level.checks)
      report.add(name(check.name), check.count, check.passed ? 0 : 1, check.detail);
  }
  return report;
}

Result<VerifyReport> BisectionTerrain::verify_alone(Threads threads, Progress& progress) const {
  return verify(model_.grid, threads, progress);
}

}  // namespace lode
