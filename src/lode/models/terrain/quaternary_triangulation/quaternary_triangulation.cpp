// L. De Floriani, P. Marzano, E. Puppo, "Multiresolution models for topographic surface
// description", The Visual Computer 12 (1996), section 6: the quaternary triangulation.
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/delaunay/triangle_judge.h"
#include "lode/models/terrain/squares/tin_builder.h"

namespace lode::quaternary_triangulation {
namespace {

using delaunay::LatticePoint;
using squares::Share;

constexpr float kOutside = std::numeric_limits<float>::infinity();

std::array<LatticePoint, 3> corners_of(const HalfSquare& triangle) {
  const LatticePoint a{triangle.square.x(), triangle.square.y()};
  const std::int32_t side = triangle.square.side();
  const LatticePoint c{a.x + side, a.y + side};
  if (triangle.is_upper) return {a, c, LatticePoint{a.x, c.y}};
  return {a, LatticePoint{c.x, a.y}, c};
}

}  // namespace

HalfSquare HalfSquare::child(int i) const {
  // The halves like itself at its three corners, and the other one of the square between.
  const int between = is_upper ? 2 : 1;
  switch (i) {
    case 0: return {square.child(0), is_upper};
    case 1: return {square.child(between), is_upper};
    case 2: return {square.child(between), !is_upper};
    default: return {square.child(3), is_upper};
  }
}

double linear_error(const SquareDomain& domain, const HalfSquare& triangle) {
  const Square& square = triangle.square;
  if (square.level == 0) return 0;  // Corners are all that it has.
  const std::int32_t side = square.side();
  const double step = 1.0 / side;
  const auto corner = [&](std::int32_t u, std::int32_t v) {
    return domain.height(square.x() + u, square.y() + v);
  };
  // All heights are less one of them, as differences of near numbers are exact.
  const double base = corner(0, 0);
  const double last = corner(side, side);
  const double across = triangle.is_upper ? corner(0, side) : corner(side, 0);
  const double x_step = (triangle.is_upper ? last - across : across - base) * step;
  const double y_step = (triangle.is_upper ? across - base : last - across) * step;
  double worst = 0;
  for (std::int32_t v = 0; v <= side; ++v) {
    const double* const row = domain.row(square.y() + v) + square.x();
    const double begin = y_step * v;
    const std::int32_t from = triangle.is_upper ? 0 : v;
    const std::int32_t to = triangle.is_upper ? v : side;
    for (std::int32_t u = from; u <= to; ++u)
      worst = std::max(worst, std::abs((row[u] - base) - (begin + x_step * u)));
  }
  return worst + domain.rounding_in(square, triangle.is_upper ? squares::SquarePart::upper
                                                              : squares::SquarePart::lower);
}

Result<QuaternaryTriangulation> QuaternaryTriangulation::build(const HeightGrid& grid,
                                                               Threads threads,
                                                               Progress& progress) {
  LODE_TRY(SquareDomain domain, SquareDomain::make(grid));
  QuaternaryTriangulation tree(std::move(domain));
  for (std::int32_t level = 0; level < tree.domain_.n_levels(); ++level) {
    progress.report("errors of triangles", static_cast<double>(level) / tree.domain_.n_levels());
    auto& errors = tree.errors_.emplace_back(tree.domain_.n_squares(level));
    const std::int32_t n_columns = tree.domain_.n_columns(level);
    parallel_for(
        static_cast<std::size_t>(tree.domain_.n_rows(level)), threads, 1,
        [&](std::size_t row, int) {
          if (progress.is_cancelled()) return;
          for (std::int32_t column = 0; column < n_columns; ++column)
            for (const bool is_upper : {false, true}) {
              const HalfSquare triangle{{level, column, static_cast<std::int32_t>(row)}, is_upper};
              errors[tree.domain_.index(triangle.square)][is_upper ? 1 : 0] =
                  tree.is_whole(triangle)
                      ? delaunay::to_float_above(linear_error(tree.domain_, triangle))
                      : kOutside;
            }
        });
    if (progress.is_cancelled()) return cancelled_error();
  }
  return tree;
}

Result<QuaternaryTriangulation> QuaternaryTriangulation::of(
    SquareDomain domain, std::vector<std::vector<std::array<float, 2>>> errors) {
  QuaternaryTriangulation tree(std::move(domain));
  const SquareDomain& own = tree.domain_;
  if (errors.size() != static_cast<std::size_t>(own.n_levels()))
    return fail("expected errors of {} levels, got {}", own.n_levels(), errors.size());
  tree.errors_ = std::move(errors);
  for (std::int32_t level = 0; level < own.n_levels(); ++level) {
    const auto& of_level = tree.errors_[static_cast<std::size_t>(level)];
    if (of_level.size() != own.n_squares(level))
      return fail("expected errors of {} squares, got {}", own.n_squares(level), of_level.size());
    for (std::int32_t row = 0; row < own.n_rows(level); ++row)
      for (std::int32_t column = 0; column < own.n_columns(level); ++column)
        for (const bool is_upper : {false, true}) {
          const HalfSquare triangle{{level, column, row}, is_upper};
          if (!(tree.error(triangle) >= 0) ||
              std::isinf(tree.error(triangle)) == tree.is_whole(triangle))
            return fail("expected finite errors >= 0 of triangles in the domain, got {}",
                        tree.error(triangle));
        }
  }
  return tree;
}

bool QuaternaryTriangulation::is_whole(const HalfSquare& triangle) const {
  if (triangle.square.level == 0) return domain_.share(triangle.square) == Share::all;
  for (int i = 0; i < 4; ++i) {
    const HalfSquare child = triangle.child(i);
    if (!domain_.has(child.square) || error(child) == kOutside) return false;
  }
  return true;
}

namespace {

/// visit(triangle) of the leaves, in depth-first order, until it is false.
template <typename Split, typename Visit>
void visit_leaves(const QuaternaryTriangulation& tree, const Split& split, const Visit& visit) {
  const SquareDomain& domain = tree.domain();
  std::vector<HalfSquare> open{{domain.root(), true}, {domain.root(), false}};
  while (!open.empty()) {
    const HalfSquare triangle = open.back();
    open.pop_back();
    if (!domain.has(triangle.square)) continue;
    if (tree.is_leaf(triangle, split)) {
      if (!visit(triangle)) return;
      continue;
    }
    if (triangle.square.level == 0) continue;
    for (int i = 3; i >= 0; --i) open.push_back(triangle.child(i));
  }
}

auto errs_beyond(const QuaternaryTriangulation& tree, double tolerance) {
  return [&tree, tolerance](const HalfSquare& triangle) {
    return static_cast<double>(tree.error(triangle)) > tolerance;
  };
}

}  // namespace

std::vector<HalfSquare> QuaternaryTriangulation::leaves(double tolerance) const {
  return leaves(errs_beyond(*this, tolerance));
}

std::vector<HalfSquare> QuaternaryTriangulation::leaves(
    const std::function<bool(const HalfSquare&)>& split) const {
  std::vector<HalfSquare> leaves;
  visit_leaves(*this, split, [&](const HalfSquare& triangle) {
    leaves.push_back(triangle);
    return true;
  });
  return leaves;
}

std::uint64_t QuaternaryTriangulation::count_leaves(double tolerance, std::uint64_t most) const {
  std::uint64_t n = 0;
  visit_leaves(*this, errs_beyond(*this, tolerance),
               [&](const HalfSquare&) { return ++n <= most; });
  return n;
}

std::uint64_t QuaternaryTriangulation::n_bytes() const {
  std::uint64_t n = 0;
  for (const auto& errors : errors_) n += errors.size() * sizeof(errors[0]);
  return n + static_cast<std::uint64_t>(std::int64_t{domain_.size_x()} * domain_.size_y()) *
                 sizeof(double);
}

std::optional<HalfSquare> find_leaf(const QuaternaryTriangulation& tree, double tolerance,
                                    LatticePoint p) {
  const SquareDomain& domain = tree.domain();
  const auto split = [&](const HalfSquare& half) {
    return static_cast<double>(tree.error(half)) > tolerance;
  };
  for (const Square& cell : squares::cells_around(p)) {
    if (domain.share(cell) != Share::all) continue;
    // Of a cell on the diagonal it is the half with that of the cell which holds the sample.
    const bool is_above = p.y - cell.row >= p.x - cell.column;
    for (std::int32_t level = domain.root().level;; --level) {
      const Square square{level, cell.column >> level, cell.row >> level};
      const std::int32_t off = (cell.row - square.y()) - (cell.column - square.x());
      const HalfSquare half{square, off == 0 ? is_above : off > 0};
      if (tree.is_leaf(half, split)) return half;
    }
  }
  return std::nullopt;
}

std::uint64_t count_in_window(const QuaternaryTriangulation& tree, double tolerance,
                              const delaunay::Window& window) {
  std::uint64_t n = 0;
  const auto split = [&](const HalfSquare& half) {
    return static_cast<double>(tree.error(half)) > tolerance;
  };
  std::vector<HalfSquare> open{{tree.domain().root(), true}, {tree.domain().root(), false}};
  while (!open.empty()) {
    const HalfSquare half = open.back();
    open.pop_back();
    if (!tree.domain().has(half.square) || !meets_window(corners_of(half), window)) continue;
    if (tree.is_leaf(half, split)) {
      ++n;
      continue;
    }
    if (half.square.level == 0) continue;
    for (int i = 3; i >= 0; --i) open.push_back(half.child(i));
  }
  return n;
}

delaunay::Tin to_tin(const QuaternaryTriangulation& tree, const std::vector<HalfSquare>& leaves) {
  squares::TinBuilder builder(tree.domain());
  for (const HalfSquare& triangle : leaves) {
    const auto [a, b, c] = corners_of(triangle);
    builder.add(a, b, c, tree.error(triangle));
  }
  return builder.finish();
}

}  // namespace lode::quaternary_triangulation
