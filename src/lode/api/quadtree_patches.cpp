#include "lode/api/quadtree_patches.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "lode/core/stopwatch.h"
#include "lode/delaunay/triangle_judge.h"
#include "lode/mappers/tin_everywhere.h"
#include "lode/models/terrain/quaternary_triangulation/half_height.h"
#include "lode/models/terrain/surface_quadtree/bilinear_patch.h"

namespace lode {

using delaunay::Point;
using quadtree_file::QuadtreeModel;
using quaternary_triangulation::HalfSquare;
using squares::CellHalf;
using squares::CellHalves;
using squares::Square;
using squares::WalkStep;
using surface_quadtree::SurfaceQuadtree;

namespace {

constexpr std::uint32_t kNoLeaf = std::numeric_limits<std::uint32_t>::max();

/// Parabolas are cut until chords are so near, as shares of the tolerance or, where that is less,
/// of the range of heights: bounds grow by no more than that.
constexpr double kBendOfTolerance = 1.0 / 64;
constexpr double kBendOfRange = 1.0 / 65536;

/// The square whose half, or all but a half, some corners are.
Square square_of(const delaunay::Tin& tin, std::size_t triangle) {
  LatticePoint low = tin.vertices[tin.triangles[triangle][0]];
  LatticePoint high = low;
  for (const std::uint32_t v : tin.triangles[triangle]) {
    const LatticePoint p = tin.vertices[v];
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const auto level =
      static_cast<std::int32_t>(std::countr_zero(static_cast<std::uint32_t>(high.x - low.x)));
  return {level, low.x >> level, low.y >> level};
}

/// Whether a half of a square has its upper left corner.
bool is_upper_in(const delaunay::Tin& tin, std::size_t triangle, const Square& square) {
  return std::ranges::any_of(tin.triangles[triangle], [&](std::uint32_t v) {
    return tin.vertices[v].x == square.x() && tin.vertices[v].y == square.y() + square.side();
  });
}

Point place_at(const Point& a, const Point& b, double t) {
  if (t == 0) return a;
  if (t == 1) return b;
  return {{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])}};
}

}  // namespace

QuadtreePatches::QuadtreePatches(const QuadtreeModel& model)
    : model_(&model), grid_{domain_of(model).size_x() - 1, domain_of(model).size_y() - 1} {}

bool QuadtreePatches::is_bilinear() const {
  return std::holds_alternative<SurfaceQuadtree>(model_->tree);
}

Result<QuadtreePatches> QuadtreePatches::make(const QuadtreeModel& model, SelectedTerrain selected,
                                              const TerrainOptions& options, Progress& progress) {
  const Stopwatch watch;
  QuadtreePatches patches(model);
  patches.report_ = selected.report;
  patches.least_bend_ =
      std::max(selected.report.max_error * kBendOfTolerance,
               (model.source.range.upper - model.source.range.lower) * kBendOfRange);
  const bool is_everywhere = options.samples != nullptr;
  if (is_everywhere && !patches.is_bilinear())
    LODE_CHECK(
        raise_errors_everywhere(*options.samples, 1, options.threads, progress, selected.tin));
  patches.add_leaves(selected.tin);
  if (is_everywhere && patches.is_bilinear())
    for (Leaf& leaf : patches.leaves_)
      leaf.error = delaunay::to_float_above(surface_quadtree::error_everywhere(
          domain_of(model), leaf.square, static_cast<double>(leaf.error)));
  patches.fill_index();
  TerrainReport& report = patches.report_;
  report.is_everywhere = is_everywhere;
  report.achieved_error = 0;
  for (const Leaf& leaf : patches.leaves_)
    report.achieved_error = std::max(report.achieved_error, static_cast<double>(leaf.error));
  report.seconds += watch.seconds();
  return patches;
}

void QuadtreePatches::add_leaves(const delaunay::Tin& tin) {
  const auto* tree = std::get_if<SurfaceQuadtree>(&model_->tree);
  lower_ = upper_ = tin.vertices.front();
  for (const LatticePoint p : tin.vertices) {
    lower_ = {std::min(lower_.x, p.x), std::min(lower_.y, p.y)};
    upper_ = {std::max(upper_.x, p.x), std::max(upper_.y, p.y)};
  }
  // Of bilinear squares both triangles are there.
  for (std::size_t t = 0; t < tin.triangles.size(); t += tree != nullptr ? 2 : 1) {
    const Square square = square_of(tin, t);
    if (tree != nullptr)
      leaves_.push_back({square, false, tree->error(square)});
    else
      leaves_.push_back({square, is_upper_in(tin, t, square), tin.errors[t]});
  }
}

std::size_t QuadtreePatches::place_of(const CellHalf& half) const {
  const auto cell = static_cast<std::size_t>(std::int64_t{half.y} * grid_.n_columns + half.x);
  return is_bilinear() ? cell : 2 * cell + (half.is_upper ? 1 : 0);
}

void QuadtreePatches::fill_index() {
  const auto n_cells = static_cast<std::size_t>(std::int64_t{grid_.n_columns} * grid_.n_rows);
  index_.assign(is_bilinear() ? n_cells : 2 * n_cells, kNoLeaf);
  for (std::uint32_t i = 0; i < leaves_.size(); ++i) {
    const Square& square = leaves_[i].square;
    for (std::int32_t v = 0; v < square.side(); ++v)
      for (std::int32_t u = 0; u < square.side(); ++u)
        for (const bool is_upper : {false, true}) {
          const bool is_above = u == v ? is_upper : v > u;
          if (is_bilinear() || is_above == leaves_[i].is_upper)
            index_[place_of({square.x() + u, square.y() + v, is_upper})] = i;
        }
  }
}

std::optional<std::uint32_t> QuadtreePatches::leaf_of(const CellHalves& halves) const {
  std::uint32_t best = kNoLeaf;
  const auto key = [&](std::uint32_t i) {
    const Leaf& leaf = leaves_[i];
    return std::tuple(leaf.square.level, leaf.square.row, leaf.square.column, leaf.is_upper);
  };
  for (const CellHalf& half : halves.get()) {
    const std::uint32_t i = index_[place_of(half)];
    if (i != kNoLeaf && (best == kNoLeaf || key(i) < key(best))) best = i;
  }
  if (best == kNoLeaf) return std::nullopt;
  return best;
}

TinHeight QuadtreePatches::height_in(const Leaf& leaf, const Point& at) const {
  if (is_bilinear()) return surface_quadtree::height_in(domain_of(*model_), leaf.square, at);
  return quaternary_triangulation::height_in(domain_of(*model_),
                                             HalfSquare{leaf.square, leaf.is_upper}, at);
}

std::optional<TerrainPatches::Height> QuadtreePatches::height_at(const Point& at) const {
  const auto i = leaf_of(halves_at(grid_, at));
  if (!i) return std::nullopt;
  const TinHeight z = height_in(leaves_[*i], at);
  return Height{z.height, z.rounding, static_cast<double>(leaves_[*i].error)};
}

/// goes_on: the last of the points is on the patch before, at the place where this one begins.
void QuadtreePatches::add_piece(const Leaf& leaf, double begin, double end, const Point& a,
                                const Point& b, bool goes_on,
                                std::vector<ProfilePoint>& points) const {
  const Point from = place_at(a, b, begin);
  const Point to = place_at(a, b, end);
  const double bend = is_bilinear()
                          ? std::abs(surface_quadtree::twist_of(domain_of(*model_), leaf.square) *
                                     (to[0] - from[0]) * (to[1] - from[1])) /
                                4
                          : 0;
  const double n = bend > least_bend_ ? std::ceil(std::sqrt(bend / least_bend_)) : 1;
  const double error = static_cast<double>(leaf.error) + bend / (n * n);
  const TinHeight first = height_in(leaf, from);
  const double step = goes_on ? std::abs(points.back().height - first.height) : 0;
  if (goes_on && step <= points.back().rounding + first.rounding) {
    points.back().rounding = std::max(points.back().rounding, first.rounding + step);
    points.back().error = error;
  } else {
    if (goes_on) points.back().is_step = true;
    points.push_back({begin, from, first.height, first.rounding, error, !goes_on, false});
  }
  for (double k = 1; k <= n; ++k) {
    const double t = k == n ? end : begin + (end - begin) * k / n;
    const Point at = place_at(a, b, t);
    const TinHeight z = height_in(leaf, at);
    points.push_back({t, at, z.height, z.rounding, k == n ? 0 : error, false, false});
  }
}

std::vector<ProfilePoint> QuadtreePatches::profile(const Point& a, const Point& b) const {
  std::vector<ProfilePoint> points;
  std::uint32_t leaf = kNoLeaf;
  double begin = 0;
  double end = -1;
  double last = -1;  // Where the points end.
  const auto finish = [&] {
    if (leaf != kNoLeaf) add_piece(leaves_[leaf], begin, end, a, b, begin == last, points);
    last = end;
  };
  walk_cells(grid_, a, b, [&](const WalkStep& step) {
    const auto found = leaf_of(step.halves);
    if (!found) return;
    if (*found == leaf && step.begin == end) {
      end = step.end;
      return;
    }
    finish();
    leaf = *found;
    begin = step.begin;
    end = step.end;
  });
  finish();
  return points;
}

}  // namespace lode
