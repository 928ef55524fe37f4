#include "lode/models/terrain/right_triangle_bisection/extract.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/models/terrain/right_triangle_bisection/walk.h"

namespace lode::bisection {
namespace {

using Corners = std::array<std::uint32_t, 3>;

/// Triangles between samples, by their indices.
struct Collected {
  std::vector<Corners> corners;
  std::vector<float> errors;
};

/// A bit for each sample: numbers corners in rows, and puts the numbers for the indices.
std::vector<std::uint32_t> number_corners(std::size_t n_indices, std::vector<Corners>& triangles) {
  std::vector<std::uint64_t> words(n_indices / 64 + 1, 0);
  for (const Corners& corners : triangles)
    for (const std::uint32_t i : corners) words[i / 64] |= std::uint64_t{1} << (i % 64);
  std::vector<std::uint32_t> n_before(words.size());
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    n_before[i] = n;
    n += static_cast<std::uint32_t>(std::popcount(words[i]));
  }
  std::vector<std::uint32_t> used;
  used.reserve(n);
  for (std::size_t i = 0; i < words.size(); ++i)
    for (std::uint64_t word = words[i]; word != 0; word &= word - 1)
      used.push_back(static_cast<std::uint32_t>(64 * i) +
                     static_cast<std::uint32_t>(std::countr_zero(word)));
  for (Corners& corners : triangles)
    for (std::uint32_t& i : corners) {
      const std::uint64_t below = words[i / 64] & ((std::uint64_t{1} << (i % 64)) - 1);
      i = n_before[i / 64] + static_cast<std::uint32_t>(std::popcount(below));
    }
  return used;
}

delaunay::Tin to_tin(const Bisection& bisection, const HeightGrid& grid, Collected&& collected) {
  delaunay::Tin tin;
  const auto stride = static_cast<std::uint32_t>(bisection.lattice().stride());
  const auto used =
      number_corners(stride * static_cast<std::size_t>(grid.n_rows), collected.corners);
  tin.triangles = std::move(collected.corners);
  tin.errors = std::move(collected.errors);
  tin.vertices.reserve(used.size());
  tin.heights.reserve(used.size());
  std::visit(
      [&](const auto& samples) {
        for (const std::uint32_t i : used) {
          const auto x = static_cast<std::int32_t>(i % stride);
          const auto y = static_cast<std::int32_t>(i / stride);
          tin.vertices.push_back({x, y});
          tin.heights.push_back(
              static_cast<double>(samples[static_cast<std::size_t>(y * grid.stride + x)]));
        }
      },
      grid.heights);
  return tin;
}

/// Whether a triangle of a mesh is in the domain, as all of it is or none: as its cell next to the
/// right angle is.
class InDomain {
 public:
  explicit InDomain(const Bisection& bisection)
      : bisection_(bisection), stride_(bisection.lattice().stride()) {}

  [[nodiscard]] bool operator()(std::int64_t a, std::int64_t b, std::int64_t c) const {
    const LatticePoint p = at(a), q = at(b), apex = at(c);
    // Both ends are on the side of the apex that the cell is on, or level with it.
    const std::int32_t dx = p.x + q.x - 2 * apex.x;
    const std::int32_t dy = p.y + q.y - 2 * apex.y;
    const std::int32_t last_x = bisection_.lattice().last().x;
    const std::int32_t last_y = bisection_.lattice().last().y;
    const bool is_left = dx < 0 || apex.x == last_x;
    const bool is_below = dy < 0 || apex.y == last_y;
    return bisection_.has_cell({apex.x - (is_left ? 1 : 0), apex.y - (is_below ? 1 : 0)});
  }

 private:
  [[nodiscard]] LatticePoint at(std::int64_t i) const {
    return {static_cast<std::int32_t>(i % stride_), static_cast<std::int32_t>(i / stride_)};
  }

  const Bisection& bisection_;
  std::int64_t stride_;
};

/// visit(a, b, c, node) of all triangles in the domain.
template <typename IsRefined, typename Visit>
void walk_domain(const Bisection& bisection, const IsRefined& is_refined, const Visit& visit) {
  if (bisection.is_whole()) {
    Walk(bisection.lattice(), is_refined, visit).all();
    return;
  }
  const InDomain is_in_domain(bisection);
  const auto visit_if = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t node) {
    if (is_in_domain(a, b, c)) visit(a, b, c, node);
  };
  Walk(bisection.lattice(), is_refined, visit_if).all();
}

template <typename IsRefined>
Collected collect(const Bisection& bisection, const IsRefined& is_refined) {
  Collected collected;
  walk_domain(
      bisection, is_refined,
      [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t node) {
        collected.corners.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                                     static_cast<std::uint32_t>(c)});
        collected.errors.push_back(node < 0 ? 0.0F : bisection.errors()[node]);
      });
  return collected;
}

/// The largest float32 that is no larger: errors are compared with that.
float rounded_down(double tolerance) {
  const auto nearest = static_cast<float>(tolerance);
  return static_cast<double>(nearest) > tolerance
             ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
             : nearest;
}

}  // namespace

delaunay::Tin tin_within(const Bisection& bisection, const HeightGrid& grid, double tolerance) {
  const float* errors = bisection.errors();
  const float limit = rounded_down(tolerance);
  return to_tin(bisection, grid,
                collect(bisection, [errors, limit](std::int64_t i) { return errors[i] > limit; }));
}

delaunay::Tin tin_of(const Bisection& bisection, const HeightGrid& grid, const NodeSet& nodes) {
  return to_tin(bisection, grid,
                collect(bisection, [&nodes](std::int64_t i) { return nodes.has(i); }));
}

std::uint64_t count_triangles(const Bisection& bisection, double tolerance, std::uint64_t most) {
  const float* errors = bisection.errors();
  const float limit = rounded_down(tolerance);
  std::uint64_t n = 0;
  // Once there are too many nothing is refined any more.
  const auto is_refined = [&](std::int64_t i) { return errors[i] > limit && n <= most; };
  walk_domain(bisection, is_refined,
              [&n](std::int64_t, std::int64_t, std::int64_t, std::int64_t) { ++n; });
  return std::min(n, most + 1);
}

std::optional<double> tolerance_of_cells(const Bisection& bisection, std::uint64_t max_cells) {
  // Floats that are >= 0 are in the order of their bits.
  std::uint32_t low = 0;
  std::uint32_t high = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::max());
  const auto fits = [&](std::uint32_t bits) {
    return count_triangles(bisection, static_cast<double>(std::bit_cast<float>(bits)), max_cells) <=
           max_cells;
  };
  if (!fits(high)) return {};
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (fits(middle))
      high = middle;
    else
      low = middle + 1;
  }
  return static_cast<double>(std::bit_cast<float>(high));
}

}  // namespace lode::bisection
