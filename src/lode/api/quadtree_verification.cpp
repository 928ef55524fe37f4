#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <string>

#include "lode/api/quadtree_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/mappers/tin_quality.h"

namespace lode {
namespace {

using quaternary_triangulation::HalfSquare;
using quaternary_triangulation::QuaternaryTriangulation;
using squares::Square;
using squares::SquareDomain;
using surface_quadtree::SurfaceQuadtree;

/// Whether no square has a sample that errs by more than it states: is_beyond(square) says so of
/// one.
template <typename IsBeyond>
Result<void> check_errors(const SquareDomain& domain, Threads threads, Progress& progress,
                          const IsBeyond& is_beyond, VerifyReport& report) {
  std::atomic<std::uint64_t> n_beyond = 0;
  std::uint64_t n = 0;
  for (std::int32_t level = 0; level < domain.n_levels(); ++level) {
    n += domain.n_squares(level);
    parallel_for(static_cast<std::size_t>(domain.n_rows(level)), threads, 1,
                 [&](std::size_t row, int) {
                   if (progress.is_cancelled()) return;
                   for (std::int32_t column = 0; column < domain.n_columns(level); ++column)
                     if (is_beyond(Square{level, column, static_cast<std::int32_t>(row)}))
                       ++n_beyond;
                 });
    if (progress.is_cancelled()) return cancelled_error();
  }
  report.add("squares state their errors", n, n_beyond,
             n_beyond > 0 ? fmt::format("{} have samples that err by more", n_beyond.load()) : "");
  return {};
}

Result<void> check_errors(const SurfaceQuadtree& tree, Threads threads, Progress& progress,
                          VerifyReport& report) {
  const auto is_beyond = [&](const Square& square) {
    const double stated = tree.error(square);
    return !std::isinf(stated) && surface_quadtree::bilinear_error(tree.domain(), square) > stated;
  };
  return check_errors(tree.domain(), threads, progress, is_beyond, report);
}

Result<void> check_errors(const QuaternaryTriangulation& tree, Threads threads, Progress& progress,
                          VerifyReport& report) {
  const auto is_beyond = [&](const Square& square) {
    for (const bool is_upper : {false, true}) {
      const HalfSquare triangle{square, is_upper};
      const double stated = tree.error(triangle);
      if (!std::isinf(stated) &&
          quaternary_triangulation::linear_error(tree.domain(), triangle) > stated)
        return true;
    }
    return false;
  };
  return check_errors(tree.domain(), threads, progress, is_beyond, report);
}

/// It keeps none.
Result<void> check_errors(const SquareDomain&, Threads, Progress&, VerifyReport&) { return {}; }

}  // namespace

Result<VerifyReport> QuadtreeTerrain::verify(const HeightGrid& grid, Threads threads,
                                             Progress& progress) const {
  VerifyReport report;
  LODE_CHECK(check_source(source(), grid, report));
  check_stored_heights(model_.grid, grid, report);
  LODE_CHECK(
      std::visit([&](const auto& tree) { return check_errors(tree, threads, progress, report); },
                 model_.tree));
  for (const double tolerance : model_.levels) {
    const auto name = [&](const std::string& what) {
      return fmt::format("within {}: {}", tolerance, what);
    };
    LODE_TRY(const delaunay::Tin tin, tin_within(tolerance, progress));
    if (!domain().kept().empty()) {
      const std::uint64_t n_lost = count_lost(domain().kept(), tin);
      report.add(name("kept samples are vertices"), domain().kept().size(), n_lost,
                 n_lost > 0 ? fmt::format("{} are not", n_lost) : "");
    }
    if (const auto* tree = std::get_if<SurfaceQuadtree>(&model_.tree)) {
      // Each sample of a leaf is looked at again.
      const auto leaves = tree->leaves(tolerance);
      const bool is_same = leaves == surface_quadtree::leaves_top_down(domain(), tolerance);
      report.add(name("squares are those found from above"), leaves.size(), is_same ? 0 : 1, "");
    }
    if (!has_gaps()) {
      LODE_TRY(const VerifyReport level,
               verify_sample_tin(
                   grid, tin, {.max_error = tolerance, .shape = TinShape::any, .threads = threads},
                   progress));
      for (const VerifyReport::Check& check : level.checks)
        report.add(name(check.name), check.count, check.passed ? 0 : 1, check.detail);
      continue;
    }
    const TinQuality quality = measure_quality(tin, 1, grid, threads);
    const std::uint64_t n_out = quality.n_uncovered - source().n_left_out;
    report.add(name("the domain is covered"), quality.n_samples, n_out,
               n_out > 0 ? fmt::format("{} samples are in no triangle", n_out) : "");
    const double slack =
        0x1p-48 * std::max(std::abs(source().range.lower), std::abs(source().range.upper));
    if (std::holds_alternative<QuaternaryTriangulation>(model_.tree))
      report.add(name("samples are within the error"), quality.n_samples,
                 quality.worst_error <= tolerance + slack ? 0 : 1,
                 fmt::format("worst {}", quality.worst_error));
  }
  return report;
}

Result<VerifyReport> QuadtreeTerrain::verify_alone(Threads threads, Progress& progress) const {
  return verify(model_.grid, threads, progress);
}

}  // namespace lode
