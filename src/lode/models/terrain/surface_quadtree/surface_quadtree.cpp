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

/// split(square) says whether it is to be, but of a cell, which has no parts.
template <typename Split>
bool is_simple(const SquareDomain& domain, const Square& square, const Split& split) {
  if (domain.share(square) != Share::all) return false;
  return square.level == 0 || (domain.kept_in(square).all == 0 && !split(square));
}

/// The leaves in the domain that come of splitting; visit(square) of those that come of squares for
/// which is_wanted(square).
template <typename Split, typename Wanted, typename Visit>
void visit_leaves(const SquareDomain& domain, const Split& split, const Wanted& is_wanted,
                  const Visit& visit) {
  std::vector<Square> open{domain.root()};
  while (!open.empty()) {
    const Square square = open.back();
    open.pop_back();
    if (domain.share(square) == Share::none || !is_wanted(square)) continue;
    if (is_simple(domain, square, split)) {
      visit(square);
      continue;
    }
    for (int i = 3; i >= 0; --i) open.push_back(square.child(i));
  }
}

template <typename Split>
std::vector<Square> leaves_by(const SquareDomain& domain, const Split& split) {
  std::vector<Square> leaves;
  visit_leaves(
      domain, split, [](const Square&) { return true; },
      [&](const Square& square) { leaves.push_back(square); });
  return leaves;
}

auto beyond(const SurfaceQuadtree& tree, double tolerance) {
  return [&tree, tolerance](const Square& square) {
    return static_cast<double>(tree.error(square)) > tolerance;
  };
}

/// The two triangles of a square, which turn left.
std::array<delaunay::LatticeCorners, 2> triangles_of(const SquareDomain& domain,
                                                     const Square& square) {
  const LatticePoint a{square.x(), square.y()};
  const LatticePoint c{a.x + square.side(), a.y + square.side()};
  const LatticePoint b{c.x, a.y};
  const LatticePoint d{a.x, c.y};
  const auto height = [&](LatticePoint p) { return domain.height(p.x, p.y); };
  if (std::abs(height(a) - height(c)) <= std::abs(height(b) - height(d)))
    return {delaunay::LatticeCorners{a, b, c}, {a, c, d}};
  return {delaunay::LatticeCorners{a, b, d}, {b, c, d}};
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
  return leaves_by(domain_, beyond(*this, tolerance));
}

std::uint64_t SurfaceQuadtree::count_leaves(double tolerance, std::uint64_t most) const {
  std::uint64_t n = 0;
  visit_leaves(
      domain_, beyond(*this, tolerance), [&](const Square&) { return n <= most; },
      [&](const Square&) { ++n; });
  return n;
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

std::optional<Square> find_leaf(const SurfaceQuadtree& tree, double tolerance, LatticePoint p) {
  const SquareDomain& domain = tree.domain();
  for (const Square& cell : squares::cells_around(p)) {
    if (domain.share(cell) != Share::all) continue;
    for (std::int32_t level = domain.root().level;; --level) {
      const Square square{level, cell.column >> level, cell.row >> level};
      if (is_simple(domain, square, beyond(tree, tolerance))) return square;
    }
  }
  return std::nullopt;
}

std::uint64_t count_in_window(const SurfaceQuadtree& tree, double tolerance,
                              const delaunay::Window& window) {
  std::uint64_t n = 0;
  const auto is_wanted = [&](const Square& q) {
    return q.x() <= window.upper.x && q.y() <= window.upper.y &&
           q.x() + q.side() >= window.lower.x && q.y() + q.side() >= window.lower.y;
  };
  visit_leaves(tree.domain(), beyond(tree, tolerance), is_wanted, [&](const Square& square) {
    for (const delaunay::LatticeCorners& triangle : triangles_of(tree.domain(), square))
      n += meets_window(triangle, window) ? 1 : 0;
  });
  return n;
}

delaunay::Tin to_tin(const SurfaceQuadtree& tree, const std::vector<Square>& leaves) {
  squares::TinBuilder builder(tree.domain());
  for (const Square& square : leaves) {
    const double error = tree.error(square);
    for (const auto& [a, b, c] : triangles_of(tree.domain(), square)) builder.add(a, b, c, error);
  }
  return builder.finish();
}

}  // namespace lode::surface_quadtree
