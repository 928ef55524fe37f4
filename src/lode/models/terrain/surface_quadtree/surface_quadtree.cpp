// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 6: the surface quadtree.
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/delaunay/triangle_judge.h"
#include "lode/models/terrain/squares/tin_builder.h"

namespace lode::surface_quadtree {
namespace {

using squares::Share;

/// split(square) says whether it is to be, but of a cell, which has no parts; the leaves in the
/// domain that come of it.
template <typename Split>
std::vector<Square> leaves_by(const SquareDomain& domain, const Split& split) {
  std::vector<Square> leaves;
  std::vector<Square> open{domain.root()};
  while (!open.empty()) {
    const Square square = open.back();
    open.pop_back();
    const Share share = domain.share(square);
    if (share == Share::none) continue;
    const bool is_last = square.level == 0;
    if (share == Share::all && (is_last || (domain.kept_in(square).all == 0 && !split(square)))) {
      leaves.push_back(square);
      continue;
    }
    for (int i = 3; i >= 0; --i) open.push_back(square.child(i));
  }
  return leaves;
}

}  // namespace

double bilinear_error(const SquareDomain& domain, const Square& square) {
  if (square.level == 0) return 0;  // Corners are all that it has.
  const std::int32_t side = square.side();
  const double step = 1.0 / side;
  const auto corner = [&](std::int32_t u, std::int32_t v) {
    return domain.height(square.x() + u, square.y() + v);
  };
  // All heights are less one of them, as differences of near numbers are exact.
  const double base = corner(0, 0);
  const double left_step = (corner(0, side) - base) * step;
  const double right = corner(side, 0) - base;
  const double right_step = (corner(side, side) - corner(side, 0)) * step;
  double worst = 0;
  for (std::int32_t v = 0; v <= side; ++v) {
    const double begin = left_step * v;
    const double slope = (right + right_step * v - begin) * step;
    const double* const row = domain.row(square.y() + v) + square.x();
    for (std::int32_t u = 0; u <= side; ++u)
      worst = std::max(worst, std::abs((row[u] - base) - (begin + slope * u)));
  }
  return worst + domain.rounding_in(square, squares::SquarePart::all);
}

Result<SurfaceQuadtree> SurfaceQuadtree::build(const HeightGrid& grid, Threads threads,
                                               Progress& progress) {
  LODE_TRY(SquareDomain domain, SquareDomain::make(grid));
  SurfaceQuadtree tree(std::move(domain));
  for (std::int32_t level = 0; level < tree.domain_.n_levels(); ++level) {
    progress.report("errors of squares", static_cast<double>(level) / tree.domain_.n_levels());
    auto& errors = tree.errors_.emplace_back(tree.domain_.n_squares(level));
    const std::int32_t n_columns = tree.domain_.n_columns(level);
    parallel_for(static_cast<std::size_t>(tree.domain_.n_rows(level)), threads, 1,
                 [&](std::size_t row, int) {
                   if (progress.is_cancelled()) return;
                   for (std::int32_t column = 0; column < n_columns; ++column) {
                     const Square square{level, column, static_cast<std::int32_t>(row)};
                     errors[tree.domain_.index(square)] =
                         tree.domain_.share(square) == Share::all
                             ? delaunay::to_float_above(bilinear_error(tree.domain_, square))
                             : std::numeric_limits<float>::infinity();
                   }
                 });
    if (progress.is_cancelled()) return cancelled_error();
  }
  return tree;
}

Result<SurfaceQuadtree> SurfaceQuadtree::of(SquareDomain domain,
                                            std::vector<std::vector<float>> errors) {
  SurfaceQuadtree tree(std::move(domain));
  const SquareDomain& own = tree.domain_;
  if (errors.size() != static_cast<std::size_t>(own.n_levels()))
    return fail("expected errors of {} levels, got {}", own.n_levels(), errors.size());
  for (std::int32_t level = 0; level < own.n_levels(); ++level) {
    const auto& of_level = errors[static_cast<std::size_t>(level)];
    if (of_level.size() != own.n_squares(level))
      return fail("expected errors of {} squares, got {}", own.n_squares(level), of_level.size());
    for (std::int32_t row = 0; row < own.n_rows(level); ++row)
      for (std::int32_t column = 0; column < own.n_columns(level); ++column) {
        const Square square{level, column, row};
        const float error = of_level[own.index(square)];
        if (!(error >= 0) || std::isinf(error) != (own.share(square) != Share::all))
          return fail("expected finite errors >= 0 of squares in the domain, got {}", error);
      }
  }
  tree.errors_ = std::move(errors);
  return tree;
}

std::vector<Square> SurfaceQuadtree::leaves(const std::function<bool(const Square&)>& split) const {
  return leaves_by(domain_, split);
}

std::vector<Square> SurfaceQuadtree::leaves(double tolerance) const {
  return leaves_by(domain_, [&](const Square& square) {
    return static_cast<double>(error(square)) > tolerance;
  });
}

std::uint64_t SurfaceQuadtree::n_bytes() const {
  std::uint64_t n = 0;
  for (const auto& errors : errors_) n += errors.size() * sizeof(float);
  return n + static_cast<std::uint64_t>(std::int64_t{domain_.size_x()} * domain_.size_y()) *
                 sizeof(double);
}

std::vector<Square> leaves_top_down(const SquareDomain& domain, double tolerance) {
  return leaves_by(domain, [&](const Square& square) {
    return static_cast<double>(delaunay::to_float_above(bilinear_error(domain, square))) >
           tolerance;
  });
}

delaunay::Tin to_tin(const SurfaceQuadtree& tree, const std::vector<Square>& leaves) {
  squares::TinBuilder builder(tree.domain());
  for (const Square& square : leaves) {
    const double error = tree.error(square);
    const delaunay::LatticePoint a{square.x(), square.y()};
    const delaunay::LatticePoint c{a.x + square.side(), a.y + square.side()};
    const delaunay::LatticePoint b{c.x, a.y};
    const delaunay::LatticePoint d{a.x, c.y};
    const auto height = [&](delaunay::LatticePoint p) { return tree.domain().height(p.x, p.y); };
    if (std::abs(height(a) - height(c)) <= std::abs(height(b) - height(d))) {
      builder.add(a, b, c, error);
      builder.add(a, c, d, error);
    } else {
      builder.add(a, b, d, error);
      builder.add(b, c, d, error);
    }
  }
  return builder.finish();
}

}  // namespace lode::surface_quadtree
