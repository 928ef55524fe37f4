#include "lode/models/terrain/triangle_hierarchy/locator.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/triangle_hierarchy/triangle_box.h"

namespace lode::triangle_hierarchy {
namespace {

using delaunay::Point;

Point to_point(LatticePoint p) { return {{static_cast<double>(p.x), static_cast<double>(p.y)}}; }

}  // namespace

template <typename Visit>
void Locator::visit_buckets(std::uint32_t triangle, const Visit& visit) const {
  std::array<LatticePoint, 3> corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[i] = hierarchy_->vertices[hierarchy_->triangles[triangle].corner[i]];
  const auto [x_low, x_high] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [y_low, y_high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  const auto side = static_cast<std::int64_t>(bucket_side_);
  for (std::int32_t y = row(y_low); y <= row(y_high); ++y)
    for (std::int32_t x = column(x_low); x <= column(x_high); ++x)
      if (!is_apart(corners, {x * side, y * side, (x + 1) * side, (y + 1) * side}))
        visit(std::int64_t{y} * n_columns_ + x);
}

Locator::Locator(const Hierarchy& hierarchy) : hierarchy_(&hierarchy) {
  const std::uint32_t n = hierarchy.triangles_until[0];
  const double width = std::ldexp(hierarchy.frame.n_columns - 1, hierarchy.bits);
  const double height = std::ldexp(hierarchy.frame.n_rows - 1, hierarchy.bits);
  bucket_side_ = std::ceil(std::max(std::sqrt(width / n * height), std::max(width, height) / 4096));
  n_columns_ = static_cast<std::int32_t>(width / bucket_side_) + 1;
  n_rows_ = static_cast<std::int32_t>(height / bucket_side_) + 1;
  first_.assign(static_cast<std::size_t>(std::int64_t{n_columns_} * n_rows_) + 1, 0);
  const auto at = [](std::int64_t bucket) { return static_cast<std::size_t>(bucket); };
  for (std::uint32_t t = 0; t < n; ++t)
    visit_buckets(t, [&](std::int64_t bucket) { ++first_[at(bucket) + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  entries_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < n; ++t)
    visit_buckets(t, [&](std::int64_t bucket) { entries_[next[at(bucket)]++] = t; });
}

std::int32_t Locator::column(double x) const {
  return static_cast<std::int32_t>(std::clamp(x / bucket_side_, 0.0, n_columns_ - 1.0));
}

std::int32_t Locator::row(double y) const {
  return static_cast<std::int32_t>(std::clamp(y / bucket_side_, 0.0, n_rows_ - 1.0));
}

bool Locator::holds(std::uint32_t triangle, const Point& fine) const {
  const auto& corner = hierarchy_->triangles[triangle].corner;
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::orientation(to_point(hierarchy_->vertices[corner[i]]),
                              to_point(hierarchy_->vertices[corner[(i + 1) % 3]]), fine) < 0)
      return false;
  return true;
}

std::optional<std::uint32_t> Locator::find(int level, Point place) const {
  const double scale = hierarchy_->scale();
  const Point fine = place * scale;
  if (!(std::isfinite(fine[0]) && std::isfinite(fine[1]))) return {};
  const auto bucket =
      static_cast<std::size_t>(std::int64_t{row(fine[1])} * n_columns_ + column(fine[0]));
  std::uint32_t found = kNone;
  for (std::uint32_t i = first_[bucket]; i < first_[bucket + 1] && found == kNone; ++i)
    if (holds(entries_[i], fine)) found = entries_[i];
  if (found == kNone) return {};
  while (!hierarchy_->is_in_level(found, level)) {
    const std::uint32_t refinement = hierarchy_->triangles[found].refinement;
    const auto [first, end] = hierarchy_->triangles_of(refinement);
    std::uint32_t t = first;
    while (t < end && !holds(t, fine)) ++t;
    if (t == end) return find_nearby(level, found, fine);
    found = t;
  }
  return found;
}

double Locator::distance_out(std::uint32_t triangle, const Point& fine) const {
  const auto& corner = hierarchy_->triangles[triangle].corner;
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point a = to_point(hierarchy_->vertices[corner[i]]);
    const Point along = to_point(hierarchy_->vertices[corner[(i + 1) % 3]]) - a;
    const Point to = fine - a;
    const double right = along[1] * to[0] - along[0] * to[1];
    most = std::max(most, right / std::hypot(along[0], along[1]));
  }
  return most;
}

/// Vertices of an edge have been moved onto the lattice, and a place next to it is now in another
/// triangle's part: round the triangle that it is closest to, more or less.
std::optional<std::uint32_t> Locator::find_nearby(int level, std::uint32_t start,
                                                  const Point& fine) const {
  while (!hierarchy_->is_in_level(start, level)) {
    const auto [first, end] = hierarchy_->triangles_of(hierarchy_->triangles[start].refinement);
    start = first;
    for (std::uint32_t t = first; t < end; ++t)
      if (distance_out(t, fine) < distance_out(start, fine)) start = t;
  }
  std::vector<std::uint32_t> seen{start};
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (holds(seen[i], fine)) return seen[i];
    for (unsigned edge = 0; edge < 3; ++edge) {
      const std::uint32_t twin = hierarchy_->neighbour(level, seen[i], edge);
      if (twin == delaunay::kNoHalfEdge) continue;
      if (std::ranges::find(seen, twin >> 2) == seen.end()) seen.push_back(twin >> 2);
    }
  }
  return {};
}

std::vector<std::uint32_t> find_in_window(const Hierarchy& hierarchy, int level,
                                          const Window& window) {
  const std::int64_t scale = hierarchy.scale();
  const FineBox box{window.lower.x * scale, window.lower.y * scale, window.upper.x * scale,
                    window.upper.y * scale};
  const std::int64_t reach = hierarchy.reach;
  const FineBox wider{box.x_low - reach, box.y_low - reach, box.x_high + reach, box.y_high + reach};
  std::vector<std::uint32_t> open(hierarchy.triangles_until[0]);
  std::iota(open.begin(), open.end(), 0U);
  std::vector<std::uint32_t> found;
  while (!open.empty()) {
    const std::uint32_t t = open.back();
    open.pop_back();
    std::array<LatticePoint, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = hierarchy.vertices[hierarchy.triangles[t].corner[i]];
    const bool is_last = hierarchy.is_in_level(t, level);
    if (is_apart(corners, is_last ? box : wider)) continue;
    if (is_last) {
      found.push_back(t);
      continue;
    }
    const auto [first, end] = hierarchy.triangles_of(hierarchy.triangles[t].refinement);
    for (std::uint32_t child = first; child < end; ++child) open.push_back(child);
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace lode::triangle_hierarchy
