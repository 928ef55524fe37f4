#include "lode/mappers/simple_rings.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "lode/delaunay/predicates.h"

namespace lode {
namespace {

using RingPoint = Vec<double, 2>;

/// Whether p, which is on no edge of the ring, is inside.
bool is_inside(const Ring& ring, const RingPoint& p) {
  bool is_in = false;
  for (std::size_t i = 1; i < ring.size(); ++i) {
    const RingPoint& a = ring[i - 1];
    const RingPoint& b = ring[i];
    if ((a[1] > p[1]) == (b[1] > p[1])) continue;
    const double x = a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
    is_in = is_in != (p[0] < x);
  }
  return is_in;
}

/// A point of the hole that is no corner of the outer ring, as these may touch it.
RingPoint probe_of(const Ring& hole, const Ring& outer) {
  for (std::size_t i = 1; i < hole.size(); ++i)
    if (std::ranges::find(outer, hole[i]) == outer.end()) return hole[i];
  return (hole[0] + hole[1]) * 0.5;
}

struct Extent2 {
  RingPoint lower;
  RingPoint upper;

  [[nodiscard]] bool holds(const Extent2& other) const {
    return lower[0] <= other.lower[0] && lower[1] <= other.lower[1] && upper[0] >= other.upper[0] &&
           upper[1] >= other.upper[1];
  }
};

Extent2 extent_of(const Ring& ring) {
  Extent2 extent{ring[0], ring[0]};
  for (const RingPoint& p : ring)
    for (std::size_t i = 0; i < 2; ++i) {
      extent.lower[i] = std::min(extent.lower[i], p[i]);
      extent.upper[i] = std::max(extent.upper[i], p[i]);
    }
  return extent;
}

struct Segment2 {
  RingPoint from;
  RingPoint to;

  friend auto operator<=>(const Segment2&, const Segment2&) = default;
};

/// Segments of rings without those that others run along the other way.
std::vector<Segment2> one_way_segments(const std::vector<Ring>& rings) {
  std::vector<Segment2> all;
  for (const Ring& ring : rings)
    for (std::size_t i = 1; i < ring.size(); ++i)
      if (ring[i - 1] != ring[i]) all.push_back({ring[i - 1], ring[i]});
  std::ranges::sort(all);
  std::vector<Segment2> left;
  for (const Segment2& one : all)
    if (!std::ranges::binary_search(all, Segment2{one.to, one.from})) left.push_back(one);
  return left;
}

/// Whether, turning right round `at` from `back`, p comes before q.
bool comes_first(const RingPoint& at, const RingPoint& back, const RingPoint& p,
                 const RingPoint& q) {
  // Half a turn to the right of `back`, or what is left of it.
  const auto half = [&](const RingPoint& r) {
    return delaunay::orientation(at, back, r) > 0 ? 1 : 0;
  };
  if (half(p) != half(q)) return half(p) < half(q);
  return delaunay::orientation(at, p, q) < 0;
}

bool has_repeated_points(const std::vector<Ring>& rings) {
  std::vector<RingPoint> points;
  for (const Ring& ring : rings) points.insert(points.end(), ring.begin() + 1, ring.end());
  std::ranges::sort(points);
  return std::ranges::adjacent_find(points) != points.end();
}

}  // namespace

double doubled_area(const Ring& ring) {
  double area = 0;
  // Relative to the first point, so that nothing cancels far from the origin.
  for (std::size_t i = 1; i < ring.size(); ++i) {
    const RingPoint a = ring[i - 1] - ring[0];
    const RingPoint b = ring[i] - ring[0];
    area += a[0] * b[1] - a[1] * b[0];
  }
  return area;
}

std::vector<Ring> cut_at_repeated_points(const Ring& ring) {
  std::vector<Ring> simple;
  Ring open;
  std::map<RingPoint, std::size_t> place_of;  // In `open`.
  for (const RingPoint& p : ring) {
    const auto [known, is_new] = place_of.try_emplace(p, open.size());
    if (is_new) {
      open.push_back(p);
      continue;
    }
    // From there to here it is a ring; the point stays for what comes.
    const std::size_t first = known->second;
    Ring closed(open.begin() + static_cast<std::ptrdiff_t>(first), open.end());
    for (std::size_t i = first + 1; i < open.size(); ++i) place_of.erase(open[i]);
    open.resize(first + 1);
    closed.push_back(p);
    if (closed.size() > 3 && doubled_area(closed) != 0) simple.push_back(std::move(closed));
  }
  return simple;
}

std::vector<Ring> follow_inside(const std::vector<Ring>& rings) {
  if (!has_repeated_points(rings)) return rings;
  const std::vector<Segment2> segments = one_way_segments(rings);
  std::vector<bool> is_done(segments.size(), false);
  const auto next_of = [&](const Segment2& segment) {
    auto next = std::ranges::lower_bound(segments, segment.to, {}, &Segment2::from);
    for (auto other = next; other != segments.end() && other->from == segment.to; ++other)
      if (comes_first(segment.to, segment.from, other->to, next->to)) next = other;
    return static_cast<std::size_t>(next - segments.begin());
  };
  std::vector<Ring> made;
  for (std::size_t first = 0; first < segments.size(); ++first) {
    if (is_done[first]) continue;
    Ring ring{segments[first].from};
    // As many segments come to a point as leave it, so each has one that goes on from it.
    for (std::size_t at = first; at < segments.size() && !is_done[at]; at = next_of(segments[at])) {
      is_done[at] = true;
      ring.push_back(segments[at].to);
    }
    if (ring.size() > 3 && ring.front() == ring.back()) made.push_back(std::move(ring));
  }
  return made;
}

std::vector<RingPolygon> nest_rings(std::vector<Ring> rings) {
  std::vector<RingPolygon> polygons;
  std::vector<Extent2> extents;
  std::vector<double> areas;
  std::vector<Ring> holes;
  for (Ring& ring : rings) {
    const double area = doubled_area(ring);
    if (area > 0) {
      extents.push_back(extent_of(ring));
      polygons.push_back({std::move(ring)});
      areas.push_back(area);
    } else {
      holes.push_back(std::move(ring));
    }
  }
  std::vector<std::size_t> by_area(polygons.size());
  std::iota(by_area.begin(), by_area.end(), std::size_t{0});
  std::ranges::stable_sort(by_area, {}, [&](std::size_t i) { return areas[i]; });
  for (Ring& hole : holes) {
    const Extent2 extent = extent_of(hole);
    std::optional<std::size_t> last;  // The smallest that may be round it, not looked at yet.
    for (const std::size_t i : by_area) {
      if (!extents[i].holds(extent)) continue;
      if (last && is_inside(polygons[*last][0], probe_of(hole, polygons[*last][0]))) break;
      last = i;
    }
    if (last) polygons[*last].push_back(std::move(hole));
  }
  return polygons;
}

}  // namespace lode
