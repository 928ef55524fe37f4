#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>
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

/// Whether a sample of a square errs by more than `stated`, in 64 bits of mantissa: weights(u, v),
/// whole numbers that are side² together with that of the lower left corner, are those of the lower
/// right, the upper left and the upper right one; none where the sample is of no interest.
template <typename Weights>
bool errs_beyond(const SquareDomain& domain, const Square& square, double stated,
                 const Weights& weights) {
  const std::int32_t side = square.side();
  const auto way = [&](std::int32_t u, std::int32_t v) {
    return static_cast<long double>(domain.height(square.x() + u, square.y() + v)) -
           domain.height(square.x(), square.y());
  };
  const std::array<long double, 3> ways{way(side, 0), way(0, side), way(side, side)};
  const auto area = static_cast<long double>(std::int64_t{side} * side);
  for (std::int32_t v = 0; v <= side; ++v)
    for (std::int32_t u = 0; u <= side; ++u) {
      const std::optional<std::array<std::int64_t, 3>> weight = weights(u, v);
      if (!weight) continue;
      long double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) sum += static_cast<long double>((*weight)[i]) * ways[i];
      if (std::abs(way(u, v) * area - sum) > stated * area) return true;
    }
  return false;
}

bool errs_beyond(const SurfaceQuadtree& tree, const Square& square) {
  const std::int64_t side = square.side();
  return errs_beyond(tree.domain(), square, tree.error(square),
                     [&](std::int64_t u, std::int64_t v) {
                       return std::optional(std::array{u * (side - v), (side - u) * v, u * v});
                     });
}

bool errs_beyond(const QuaternaryTriangulation& tree, const HalfSquare& half) {
  using Weights = std::array<std::int64_t, 3>;
  const std::int64_t side = half.square.side();
  return errs_beyond(
      tree.domain(), half.square, tree.error(half),
      [&](std::int64_t u, std::int64_t v) -> std::optional<Weights> {
        if (half.is_upper)
          return v < u ? std::nullopt : std::optional(Weights{0, (v - u) * side, u * side});
        return u < v ? std::nullopt : std::optional(Weights{(u - v) * side, 0, v * side});
      });
}

Result<void> check_errors(const SurfaceQuadtree& tree, Threads threads, Progress& progress,
                          VerifyReport& report) {
  const auto is_beyond = [&](const Square& square) {
    return !std::isinf(tree.error(square)) && errs_beyond(tree, square);
  };
  return check_errors(tree.domain(), threads, progress, is_beyond, report);
}

Result<void> check_errors(const QuaternaryTriangulation& tree, Threads threads, Progress& progress,
                          VerifyReport& report) {
  const auto is_beyond = [&](const Square& square) {
    for (const bool is_upper : {false, true}) {
      const HalfSquare triangle{square, is_upper};
      if (!std::isinf(tree.error(triangle)) && errs_beyond(tree, triangle)) return true;
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
    if (std::holds_alternative<QuaternaryTriangulation>(model_.tree))
      report.add(name("samples are within the error"), quality.n_samples,
                 quality.worst_error <= tolerance ? 0 : 1,
                 fmt::format("worst {}", quality.worst_error));
  }
  return report;
}

Result<VerifyReport> QuadtreeTerrain::verify_alone(Threads threads, Progress& progress) const {
  return verify(model_.grid, threads, progress);
}

}  // namespace lode
