#include "lode/mappers/facet_grid.h"

#include <algorithm>
#include <cmath>

#include "lode/core/point_triangle.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_pieces.h"

namespace lode {
namespace {

Vec3d middle_of(const std::array<Vec3d, 3>& t) { return (t[0] + t[1] + t[2]) * (1.0 / 3); }

/// From p to the box round a triangle: of a long one most of its ball is empty.
double squared_distance_to_box(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = std::min(std::min(t[0][i], t[1][i]), t[2][i]);
    const double high = std::max(std::max(t[0][i], t[1][i]), t[2][i]);
    const double beyond = std::max(std::max(low - p[i], p[i] - high), 0.0);
    sum += beyond * beyond;
  }
  return sum;
}

}  // namespace

FacetGrid::FacetGrid(std::span<const Facet> facets, double reach) : facets_(facets) {
  choose_cells(reach);
  radii_.reserve(facets_.size());
  for (const Facet& facet : facets_)
    radii_.push_back(static_cast<float>(simplification::radius_of(corners_of(facet)) * (1 + 1e-6)));
  const std::size_t n_cells = static_cast<std::size_t>(dims_[0]) *
                              static_cast<std::size_t>(dims_[1]) *
                              static_cast<std::size_t>(dims_[2]);
  first_.assign(n_cells + 1, 0);
  const auto visit_all = [&](const auto& visit) {
    std::vector<std::size_t> cells;
    for (std::uint32_t f = 0; f < facets_.size(); ++f) {
      cells.clear();
      const bool is_whole =
          for_each_cell(corners_of(facets_[f]), [&](std::size_t cell) { cells.push_back(cell); });
      if (!is_whole) {  // else it comes to none twice
        std::sort(cells.begin(), cells.end());
        cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
      }
      for (const std::size_t cell : cells) visit(cell, f);
    }
  };
  visit_all([&](std::size_t cell, std::uint32_t) { ++first_[cell + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  entries_.resize(first_.back());
  visit_all([&](std::size_t cell, std::uint32_t f) { entries_[first_[cell]++] = f; });
  for (std::size_t c = first_.size() - 1; c > 0; --c) first_[c] = first_[c - 1];
  first_[0] = 0;
}

/// Along each axis cells are no smaller than half the reach, or than half of what facets extend,
/// and not many more than facets.
void FacetGrid::choose_cells(double reach) {
  constexpr double kCellsPerFacet = 8;
  if (facets_.empty()) return;
  constexpr double kFar = std::numeric_limits<double>::max();
  lower_ = {{kFar, kFar, kFar}};
  Vec3d upper = -1.0 * lower_;
  Vec3d extent;
  for (const Facet& facet : facets_) {
    const auto corners = corners_of(facet);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax({corners[0][i], corners[1][i], corners[2][i]});
      lower_[i] = std::min(lower_[i], low);
      upper[i] = std::max(upper[i], high);
      extent[i] += high - low;
    }
  }
  const Vec3d size = upper - lower_;
  const auto n_facets = static_cast<double>(facets_.size());
  for (std::size_t i = 0; i < 3; ++i)
    edge_[i] = std::max({reach / 2, extent[i] / n_facets / 2, size[i] / 4096, 1e-30});
  const auto n_cells = [&] {
    double n = 1;
    for (std::size_t i = 0; i < 3; ++i) n *= std::floor(size[i] / edge_[i]) + 1;
    return n;
  };
  while (n_cells() > kCellsPerFacet * n_facets + 64) edge_ = edge_ * 1.25;
  for (std::size_t i = 0; i < 3; ++i)
    dims_[i] = static_cast<std::int32_t>(std::floor(size[i] / edge_[i])) + 1;
}

std::size_t FacetGrid::n_most_in_cell() const {
  std::uint32_t n_most = 0;
  for (std::size_t c = 1; c < first_.size(); ++c)
    n_most = std::max(n_most, first_[c] - first_[c - 1]);
  return n_most;
}

std::int32_t FacetGrid::coordinate(double x, std::size_t axis) const {
  const double cell = std::floor((x - lower_[axis]) / edge_[axis]);
  return static_cast<std::int32_t>(std::clamp(cell, 0.0, static_cast<double>(dims_[axis] - 1)));
}

template <typename Visit>
bool FacetGrid::for_each_cell(const std::array<Vec3d, 3>& piece, const Visit& visit) const {
  Cell low;
  Cell high;
  bool is_large = false;
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] = coordinate(std::min({piece[0][i], piece[1][i], piece[2][i]}), i);
    high[i] = coordinate(std::max({piece[0][i], piece[1][i], piece[2][i]}), i);
    is_large = is_large || high[i] - low[i] > 2;
  }
  if (is_large) {
    for (const auto& part : simplification::quarters(piece)) for_each_cell(part, visit);
    return false;
  }
  for (std::int32_t z = low[2]; z <= high[2]; ++z)
    for (std::int32_t y = low[1]; y <= high[1]; ++y)
      for (std::int32_t x = low[0]; x <= high[0]; ++x) visit(number({x, y, z}));
  return true;
}

double FacetGrid::squared_distance(const Vec3d& p, const Cell& c) const {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = lower_[i] + c[i] * edge_[i];
    const double beyond = std::max({low - p[i], p[i] - (low + edge_[i]), 0.0});
    sum += beyond * beyond;
  }
  return sum;
}

bool FacetGrid::look_in(const Cell& c, const Vec3d& p, double enough, Nearest& nearest) const {
  const std::size_t cell = number(c);
  double reach = std::sqrt(nearest.squared_distance);
  for (std::uint32_t e = first_[cell]; e < first_[cell + 1]; ++e) {
    const std::uint32_t f = entries_[e];
    const auto corners = corners_of(facets_[f]);
    const Vec3d to_middle = p - middle_of(corners);
    const double from_middle = dot(to_middle, to_middle);
    if (from_middle <= enough) {
      nearest = {f, from_middle};
      return true;
    }
    const double beyond = reach + static_cast<double>(radii_[f]);
    if (from_middle > beyond * beyond) continue;
    if (squared_distance_to_box(p, corners) > nearest.squared_distance) continue;
    const double here = squared_distance_to_triangle(p, corners);
    if (here >= nearest.squared_distance) continue;
    nearest = {f, here};
    if (here <= enough) return true;
    reach = std::sqrt(here);
  }
  return false;
}

FacetGrid::Nearest FacetGrid::find(const Vec3d& p, const Search& search) const {
  if (facets_.empty()) return {};
  const double enough = search.enough * search.enough;
  Nearest found{kNone, search.limit * search.limit};
  if (search.hint != kNone) {
    const double here = squared_distance_to_triangle(p, corners_of(facets_[search.hint]));
    if (here <= found.squared_distance) found = {search.hint, here};
    if (here <= enough) return found;
  }
  Cell own;
  for (std::size_t i = 0; i < 3; ++i) own[i] = coordinate(p[i], i);
  if (look_in(own, p, enough, found)) return found;
  const double reach = std::sqrt(found.squared_distance);
  Cell low;
  Cell high;
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] = coordinate(p[i] - reach, i);
    high[i] = coordinate(p[i] + reach, i);
  }
  for (std::int32_t z = low[2]; z <= high[2]; ++z)
    for (std::int32_t y = low[1]; y <= high[1]; ++y)
      for (std::int32_t x = low[0]; x <= high[0]; ++x) {
        const Cell c{x, y, z};
        if (c == own || squared_distance(p, c) > found.squared_distance) continue;
        if (look_in(c, p, enough, found)) return found;
      }
  return found;
}

}  // namespace lode
